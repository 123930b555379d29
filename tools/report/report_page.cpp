#include "tools/report/report_page.hpp"

#include <algorithm>
#include <array>

#include "libfit/core/error.hpp"
#include "libfit/core/perception.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/core/statistics.hpp"
#include "libfit/fit/spline/monotone_least_squares.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/files/files.hpp"
#include "libfit/validation/statement.hpp"

namespace palpate::tools {
namespace {

namespace fs = std::filesystem;

// Files of a run, in the order of its stages.
constexpr const char* kFiles[] = {
    "body.h5",  "placed.h5",  "samples.h5",   "samples.signals.h5", "curves.h5",
    "model.h5", "asset.palp", "reference.h5", "validation.csv",     "statement.json"};

void check_is_run(const fs::path& folder) {
  if (!fs::is_directory(folder))
    throw Error(folder.string(), "is no folder", "Give the folder of a `palpate run`.");
  for (const char* name : kFiles)
    if (fs::exists(folder / name)) return;
  if (fs::exists(folder / "study.json"))
    throw Error(folder.string(), "is a study, which has its table in results.csv",
                "Give the folder of one of its cases, or draw the table in Python.");
  throw Error(folder.string(), "holds no file of a run",
              "Give the folder of a `palpate run`, or one with samples.h5 and curves.h5.");
}

Json begin(const std::string& name) {
  return {{"schema", "palpate-report"},
          {"version", 1},
          {"program", "palpate " PALPATE_VERSION},
          {"name", name},
          {"jnd",
           {{"floor_N", perception().force_floor_N},
            {"share", perception().force_at_rest},
            {"moving", perception().force_in_motion},
            {"direction_deg", perception().direction_deg}}},
          {"band_deviations", fit::kBand90},
          {"warnings", Json::array()}};
}

// Names and remarks may hold bytes that are no UTF-8, which JSON cannot.
std::string text_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

// The place of the data in tools/page/page.html: the content of a <script type="application/json">.
constexpr std::string_view kPlace = "{\"schema\":\"none\"}";

// Indices of the recordings that are shown: refused ones first, then from poor to good. Of more
// than 1000 (2.5 MB of a page) as many of each grade in that order, equally spaced, as there is
// room for.
std::vector<std::size_t> chosen(const std::vector<std::int8_t>& grades) {
  std::vector<std::size_t> shown;
  for (int grade = kRefusedGrade; grade >= 0; --grade) {
    std::vector<std::size_t> of_grade;
    for (std::size_t i = 0; i < grades.size(); ++i)
      if (grades[i] == grade) of_grade.push_back(i);
    const std::size_t room = std::min(of_grade.size(), 1000 - shown.size());
    for (std::size_t k = 0; k < room; ++k) shown.push_back(of_grade[k * of_grade.size() / room]);
  }
  return shown;
}

// Recordings as the page draws them.
Json pictures_json(const RecordedSignals& signals) {
  std::array<int, kRecordingGradeNames.size()> all{};
  for (const std::int8_t grade : signals.grade) ++all[grade];
  std::vector<std::ptrdiff_t> first{0};  // reading of each recording
  for (const std::int32_t own : signals.readings) first.push_back(first.back() + own);
  const std::vector<std::size_t> shown = chosen(signals.grade);
  const auto listed = [&](const auto& column) {
    Json list = Json::array();
    for (const std::size_t i : shown) list.push_back(column[i]);
    return list;
  };
  const auto numbers = [&](const auto& column) { return packed_as<float>(listed(column)); };
  const auto readings = [&](const auto& column) {
    auto list = column;
    list.clear();
    for (const std::size_t i : shown)
      list.insert(list.end(), column.begin() + first[i], column.begin() + first[i + 1]);
    return list;
  };
  return {{"grade_names", kRecordingGradeNames},
          {"all", all},
          {"file", listed(signals.file)},
          {"point", listed(signals.point)},
          {"reasons", listed(signals.reasons)},
          {"estimator", listed(signals.estimator)},
          {"grade", listed(signals.grade)},
          {"experiment", listed(signals.experiment)},
          {"readings", listed(signals.readings)},
          {"contact_m", numbers(signals.contact_m)},
          {"contact_deviation_m", numbers(signals.contact_deviation_m)},
          {"noise_N", numbers(signals.noise_N)},
          {"bias_N", numbers(signals.bias_N)},
          {"drift_N_m", numbers(signals.drift_N_m)},
          {"travel_m", packed_as<float>(readings(signals.travel_m))},
          {"push_N", packed_as<float>(readings(signals.push_N))},
          {"is_used", packed(readings(signals.is_used))}};
}

// The recordings behind the samples, where their signals are of the same import.
void add_pictures(Json& json, const fs::path& folder) {
  const fs::path samples = folder / "samples.h5", signals = signals_path(samples);
  if (read_attributes(signals).at(kInputsAttribute) !=
      read_attributes(samples).at(kInputsAttribute)) {
    json["warnings"].push_back(
        "samples.signals.h5 is of another import than samples.h5, so no recording is shown: run "
        "`palpate import` again.");
    return;
  }
  json["pictures"] = pictures_json(read_signals(signals));
}

Json contents_of(const fs::path& folder) {
  const auto has = [&](const char* name) { return fs::exists(folder / name); };
  Json json =
      begin(fs::absolute(folder / ".").lexically_normal().parent_path().filename().string());
  if (has("statement.json")) {
    const std::string text = read_whole_file(folder / "statement.json");
    validation::parse_statement(text, (folder / "statement.json").string());  // or it throws
    json["statement"] = Json::parse(text);
  }
  // The body as experiments were made on it.
  if (has("placed.h5") || has("body.h5"))
    add_body(json, read_body(folder / (has("placed.h5") ? "placed.h5" : "body.h5")));
  if (has("model.h5")) add_model(json, read_model(folder / "model.h5"));
  std::optional<FittedCurves> fitted;
  if (has("curves.h5")) {
    fitted = read_curves(folder / "curves.h5");
    add_curves(json, *fitted);
  }
  if (has("samples.h5"))
    add_samples(json, read_samples(folder / "samples.h5"), fitted ? &*fitted : nullptr);
  if (has("samples.h5") && has("samples.signals.h5")) add_pictures(json, folder);
  if (has("validation.csv")) add_held_out(json, folder / "validation.csv");
  if (has("asset.palp")) add_asset(json, folder / "asset.palp");
  return json;
}

}  // namespace

std::string contents_of_folder(const std::string& folder) {
  check_is_run(folder);
  return text_of(contents_of(folder));
}

std::string contents_of_set_up(const std::string& name, const Body& body,
                               const std::vector<std::string>& warnings) {
  Json json = begin(name);
  add_body(json, body);
  for (const std::string& sentence : warnings) json["warnings"].push_back(sentence);
  return text_of(json);
}

std::optional<fs::path> find_page() {
  std::error_code ignored;
  const fs::path folder = fs::read_symlink("/proc/self/exe", ignored).parent_path();
  for (const char* place : {"../share/palpate/page.html", "page/page.html"})
    if (fs::is_regular_file(folder / place, ignored)) return (folder / place).lexically_normal();
  return std::nullopt;
}

void write_page(const fs::path& output, const std::string& contents) {
  const auto path = find_page();
  if (!path)
    throw Error("report", "the page that it fills is not there (share/palpate/page.html)",
                "Install Node.js 18 or newer with npm, then `cmake --build build/PRESET --target "
                "palpate_page`, or copy the page from another installation.");
  const std::string page = read_whole_file(*path);
  const std::size_t at = page.find(kPlace);
  if (at == std::string::npos)
    throw Error(path->string(), "is no page of Palpate's",
                "Build it again: `cmake --build build/PRESET --target palpate_page`.");
  AtomicFile file(output);
  file.write(std::string_view(page).substr(0, at));
  // A text within may not end the element it stands in.
  std::string_view rest = contents;
  for (std::size_t less; (less = rest.find('<')) != std::string_view::npos;) {
    file.write(rest.substr(0, less));
    file.write("\\u003c");
    rest.remove_prefix(less + 1);
  }
  file.write(rest);
  file.write(std::string_view(page).substr(at + kPlace.size()));
  file.commit();
}

}  // namespace palpate::tools
