// Force curves as the Python library afmformats exports them, as a table (.tab) and as HDF5 (.h5):
// columns "force" in N, "height (measured)", "height (piezo)" or "tip position" in m, falling
// towards the body, "segment" and "time", beside "spring constant", "sensitivity" and "position x".

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <set>

#include "libfit/io/hdf5/hdf5.hpp"
#include "libfit/recordings/formats/afm_curve.hpp"
#include "libfit/recordings/formats/columns.hpp"
#include "libfit/recordings/formats/importers.hpp"

namespace palpate::importers {
namespace {

constexpr std::array kColumns{"force", "tip position", "height (measured)", "height (piezo)",
                              "time"};
constexpr std::array kNumbers{"spring constant", "sensitivity", "position x", "position y"};
constexpr std::string_view kBegin = "# BEGIN METADATA", kEnd = "# END METADATA";

struct AfmCurve {
  std::map<std::string, std::vector<double>> column;  // of one length
  std::map<std::string, double> number;
  std::vector<double> segment;  // 0 on the way in; empty where it is not said
  std::vector<std::size_t> line;
};

// Row where the second of two segments begins.
std::optional<Eigen::Index> second_of_two(const std::vector<double>& segment) {
  if (std::set<double>(segment.begin(), segment.end()).size() != 2) return std::nullopt;
  const auto change = std::adjacent_find(segment.begin(), segment.end(), std::not_equal_to<>());
  return change - segment.begin() + 1;
}

RawRecording recording_of(AfmCurve curve, const ReadSettings& settings,
                          const FailCantilever& fail) {
  const auto height = std::find_if(kColumns.begin() + 1, kColumns.end() - 1,
                                   [&](const char* name) { return curve.column.count(name) > 0; });
  if (curve.column.count("force") == 0 || height == kColumns.end() - 1)
    throw fail(fmt::format("has no column `{}`",
                           curve.column.count("force") ? "height (measured)" : "force"),
               "Export the curve again with force and height.");
  RawRecording r;
  r.line = std::move(curve.line);
  if (curve.column.count("time")) r.time_s = curve.column["time"];
  r.retract_begins = second_of_two(curve.segment);
  std::vector<double>& force_N = curve.column["force"];
  std::vector<double> inward_m = curve.column[*height];
  for (double& z : inward_m) z = -z;
  if (*height == kColumns[1]) {  // its cantilever is taken off already
    r.push_N = std::move(force_N);
    r.travel_m = std::move(inward_m);
  } else {
    const Cantilever stated{curve.number["spring constant"], curve.number["sensitivity"], 0, 0};
    const Cantilever used = cantilever_of(settings, stated, fail, r, true);
    const double k = stated.stiffness_N_m > 0 ? stated.stiffness_N_m : used.stiffness_N_m,
                 gain = stated.sensitivity_m > 0 && used.sensitivity_m > 0
                            ? used.sensitivity_m / stated.sensitivity_m
                            : 1;
    for (double& value : force_N) value *= gain / k;
    bend_cantilever(used, inward_m, force_N, r);
  }
  r.taken.push_back(*height);
  check_numbers(r, fail);
  if (curve.number.count("position x") && curve.number.count("position y"))
    place_in_plane(curve.number["position x"], curve.number["position y"], r);
  return r;
}

// `#   "spring constant": 0.02,` lines between two marks.
std::map<std::string, double> numbers_above(const TextFile& file, std::size_t end) {
  std::map<std::string, double> numbers;
  for (std::size_t i = 0; i < end; ++i) {
    std::string_view line = trimmed(file.line(i));
    if (line.starts_with('#')) line = trimmed(line.substr(1));
    const std::size_t colon = line.find("\": ");
    if (!line.starts_with('"') || colon == std::string_view::npos) continue;
    const std::string name(line.substr(1, colon - 1));
    std::string_view value = trimmed(line.substr(colon + 3));
    if (value.ends_with(',')) value.remove_suffix(1);
    if (std::find(kNumbers.begin(), kNumbers.end(), name) == kNumbers.end()) continue;
    if (const auto number = parse_number(value, '.')) numbers[name] = *number;
  }
  return numbers;
}

double segment_number(std::string_view text) {
  return text == "True" ? 1 : parse_number(text, '.').value_or(0);
}

}  // namespace

bool begins_afmformats(std::string_view head) {
  return head.find(kBegin) != std::string_view::npos && head.starts_with('#');
}

std::vector<RawRecording> read_afmformats(const std::filesystem::path& path, std::string_view bytes,
                                          const ReadSettings& settings) {
  const TextFile file(path, bytes, settings.encoding);
  std::size_t first = 0;
  while (first < file.lines() &&
         (trimmed(file.line(first)).empty() || file.line(first).starts_with('#')))
    ++first;
  std::size_t header = std::min(first, file.lines() - 1);
  while (header > 0 && trimmed(file.line(header)).substr(0, 1) != "#") --header;
  const FailCantilever fail = [&](const std::string& what, const std::string& remedy) {
    return file.error(header, what, remedy);
  };
  if (!trimmed(file.line(header)).starts_with('#'))
    throw fail("has no header `# force ...`", "Export the curve again.");
  const auto names = split(trimmed(file.line(header)).substr(1), '\t');
  const auto field_of = [&](std::string_view name) {  // 0.13 runs the last into the first row
    const auto is_it = [&](std::string_view field) {
      return field.starts_with(name) &&
             (field.size() == name.size() || parse_number(field.substr(name.size()), '.'));
    };
    return static_cast<std::size_t>(std::find_if(names.begin(), names.end(), is_it) -
                                    names.begin());
  };
  TableLayout layout;
  layout.first = first;
  layout.separator = '\t';
  layout.comment = "#";
  layout.drop_invalid = settings.drop_invalid;
  for (const char* name : kColumns)
    if (field_of(name) < names.size()) {
      layout.field.push_back(field_of(name));
      layout.name.emplace_back(name);
    }
  if (layout.field.empty())
    throw fail("names no column of afmformats", "Export the curve again with force and height.");
  NumberTable table = read_numbers(file, layout);
  AfmCurve curve;
  for (std::size_t c = 0; c < layout.name.size(); ++c)
    curve.column[layout.name[c]] = std::move(table.column[c]);
  if (const std::size_t field = field_of("segment"); field < names.size())
    for (const std::size_t line : table.line) {
      const auto fields = split(file.line(line - 1), '\t');
      curve.segment.push_back(field < fields.size() ? segment_number(fields[field]) : 0);
    }
  curve.line = std::move(table.line);
  curve.number = numbers_above(file, header);
  RawRecording r = recording_of(std::move(curve), settings, fail);
  r.dropped_rows = table.dropped_rows;
  return {r};
}

std::vector<RawRecording> read_afmformats_hdf5(const std::filesystem::path& path, std::string_view,
                                               const ReadSettings& settings) {
  const h5::Reader file(path, "Export the curves again.");
  std::set<std::string> curves;
  for (const std::string& set : file.data_sets())
    if (set.ends_with("/force")) curves.insert(set.substr(0, set.size() - 6));
  if (curves.empty())
    throw Error(path.string(), "is an HDF5 file without a curve of afmformats (0/force)",
                "Name its data sets under `columns` of the manifest.");
  const auto read = [&](const std::string& name) {
    AfmCurve curve;
    const auto values = [&](const std::string& set) {
      return file.numbers(set, h5::kAnyUnit, {file.shape_of(set).rows, 0});
    };
    for (const char* column : kColumns)
      if (const std::string set = name + "/" + column; file.has(set))
        curve.column[column] = values(set);
    if (const std::string set = name + "/segment"; file.has(set) && file.type_of(set) == "uint8")
      for (const std::int32_t segment :
           file.integers(set, h5::kAnyUnit, {file.shape_of(set).rows, 0}))
        curve.segment.push_back(segment);
    for (const char* number : kNumbers)
      if (file.has_attribute(name, number))
        curve.number[number] = file.number_attribute(name, number);
    const std::size_t rows = curve.column["force"].size();
    for (const auto& [column, of] : curve.column)
      if (of.size() != rows || rows == 0)
        throw file.error(name + "/" + column,
                         fmt::format("has {} rows, force has {}", of.size(), rows));
    for (std::size_t i = 0; i < rows; ++i) curve.line.push_back(i + 1);
    return recording_of(std::move(curve), settings,
                        [&](const std::string& what, const std::string& remedy) {
                          return Error(path.string() + ":" + name, what, remedy);
                        });
  };
  auto recordings = read_each(path, {curves.begin(), curves.end()}, read);
  if (recordings.size() == 1) recordings[0].name.clear();
  return recordings;
}

}  // namespace palpate::importers
