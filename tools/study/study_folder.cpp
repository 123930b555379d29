#include "tools/study/study_folder.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <ctime>
#include <nlohmann/json.hpp>

#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"
#include "libfit/io/csv/csv.hpp"
#include "libfit/io/files/files.hpp"
#include "tools/build_identity.hpp"
#include "tools/console.hpp"
#include "tools/outputs.hpp"
#include "tools/stages/body/prepare.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/stage_table.hpp"

namespace palpate::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

double peak_MB() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

Json read_json(const fs::path& path) {
  try {
    return Json::parse(read_whole_file(path));
  } catch (const Json::exception& e) {
    throw Error(path.string(), fmt::format("is damaged: {}", e.what()),
                "Delete it; the same command goes on.");
  }
}

void write_json(const fs::path& path, const Json& json) {
  write_file_atomically(path, json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

// Median over the points of force over depth, where a press's good rows end [N/m].
double median_stiffness(const Samples& samples) {
  std::vector<double> depth_m(samples.points(), 0), stiffness(depth_m);
  for (Eigen::Index row = 0; row < samples.rows(); ++row) {
    const auto r = static_cast<std::size_t>(row);
    const auto p = static_cast<std::size_t>(samples.point[r]);
    const double depth = samples.deflection.row(row).norm();
    if (samples.kind[r] != ExperimentKind::press || samples.status[r] != RowStatus::good ||
        depth <= depth_m[p])
      continue;
    depth_m[p] = depth;
    stiffness[p] = samples.force.row(row).dot(samples.point_normal.row(samples.point[r])) / depth;
  }
  std::sort(stiffness.begin(), stiffness.end());
  return stiffness.empty() ? 0 : stiffness[stiffness.size() / 2];
}

}  // namespace

void StudyFolder::plan(const fs::path& folder, const Study& study) {
  OutputFolder(folder).claim();
  fs::create_directories(folder / "cases");
  Json cases = Json::array();
  for (const StudyCase& one : study.cases) {
    const fs::path path = folder / "cases" / one.name;
    fs::create_directories(path);
    if (!fs::exists(path / "scene.toml")) write_file_atomically(path / "scene.toml", one.scene);
    cases.push_back({{"name", one.name}, {"inputs", one.inputs}, {"body", one.body}});
  }
  const ClusterSection& cluster = study.cluster;
  Json json{{"schema", "palpate-study"},
            {"program", build_identity()},
            {"study", study.path.string()},
            {"inputs", study.inputs},
            {"cluster", {{"command", cluster.command}, {"options", cluster.options}}},
            {"cases", std::move(cases)}};
  write_json(folder / "study.json", json);
}

StudyFolder::StudyFolder(const fs::path& folder) : path_(fs::absolute(folder)) {
  if (!fs::exists(path_ / "study.json"))
    throw Error(folder.string(), "holds no study",
                fmt::format("Plan one: palpate study STUDY.toml -o {}.", folder.string()));
  const Json json = read_json(path_ / "study.json");
  try {
    if (json.at("program") != build_identity())
      throw Error(folder.string(), "was planned by another version of palpate",
                  fmt::format("Go on with that version, or plan again: palpate study {} -o {}.",
                              json.at("study").get<std::string>(), folder.string()));
    study_.path = json.at("study").get<std::string>();
    study_.inputs = json.at("inputs");
    const Json& cluster = json.at("cluster");
    study_.cluster = {cluster.at("command"), cluster.at("options")};
    for (const Json& one : json.at("cases"))
      study_.cases.push_back({one.at("name"), one.at("inputs"), "", one.at("body")});
  } catch (const Json::exception& e) {
    throw Error((path_ / "study.json").string(), fmt::format("is damaged: {}", e.what()),
                "Plan the study again; what is done is kept.");
  }
}

fs::path StudyFolder::case_folder(int number) const {
  return path_ / "cases" / study_.cases[number].name;
}

void StudyFolder::run_case(int number, int jobs) const {
  const StudyCase& one = cases()[number];
  const fs::path folder = case_folder(number);
  if (fs::exists(folder / "result.json")) return;
  try {
    const std::clock_t from = std::clock();
    share_body(number);
    const RunResult run =
        tools::run({(folder / "scene.toml").string(), folder.string(), jobs, false, false});
    const Samples samples = read_samples(folder / "samples.h5");
    write_json(folder / "result.json", {{"name", listed(one.inputs)},
                                        {"points", samples.points()},
                                        {"rows", samples.rows()},
                                        {"items_failed", run.items_failed},
                                        {"median_rel", run.statement.all.force.median_rel},
                                        {"p95_rel", run.statement.all.force.p95_rel},
                                        {"max_rel", run.statement.all.force.max_rel},
                                        {"within_jnd", run.statement.within_jnd},
                                        {"reference_p95_rel", run.statement.reference_p95_rel},
                                        {"stiffness_N_m", median_stiffness(samples)},
                                        {"cpu_s", double(std::clock() - from) / CLOCKS_PER_SEC},
                                        {"memory_MB", peak_MB()}});
    std::error_code ignored;
    fs::remove(folder / "error.txt", ignored);
  } catch (const Error& e) {
    say_failed("case {}: {}", number + 1, e.what());
    write_file_atomically(folder / "error.txt", fmt::format("{}\n", e.what()));
  }
}

std::vector<int> StudyFolder::missing() const {
  std::vector<int> out;
  for (int number = 0; number < static_cast<int>(cases().size()); ++number)
    if (state(number) != CaseState::done) out.push_back(number);
  return out;
}

// The body of a case, where another case has prepared the same one.
void StudyFolder::share_body(int number) const {
  const fs::path own = case_folder(number) / "body.h5";
  for (int other = 0; !fs::exists(own) && other < static_cast<int>(cases().size()); ++other)
    if (const fs::path body = case_folder(other) / "body.h5";
        cases()[other].body == cases()[number].body && fs::exists(body))
      write_body(own, read_body(body), {{kInputsAttribute, stored_in_hdf5(body).value_or("")}});
}

CaseState StudyFolder::state(int number) const {
  const fs::path folder = case_folder(number);
  if (fs::exists(folder / "result.json")) return CaseState::done;
  if (fs::exists(folder / "error.txt")) return CaseState::failed;
  return fs::exists(folder / "body.h5") ? CaseState::partly : CaseState::waiting;
}

std::string StudyFolder::failure(int number) const {
  const fs::path path = case_folder(number) / "error.txt";
  if (!fs::exists(path)) return "";
  std::string text = read_whole_file(path);
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

void StudyFolder::forget_failures() const {
  std::error_code ignored;
  for (std::size_t i = 0; i < cases().size(); ++i)
    fs::remove(case_folder(static_cast<int>(i)) / "error.txt", ignored);
}

void StudyFolder::write_results() const {
  static constexpr std::string_view kNumbers[] = {
      "points",        "rows",    "items_failed", "median_rel",
      "p95_rel",       "max_rel", "within_jnd",   "reference_p95_rel",
      "stiffness_N_m", "cpu_s",   "memory_MB"};
  std::vector<std::string_view> header{"case", "state"};
  header.insert(header.end(), study_.inputs.begin(), study_.inputs.end());
  header.insert(header.end(), std::begin(kNumbers), std::end(kNumbers));
  header.push_back("failure");
  CsvWriter csv(path_ / "results.csv", header);
  for (int i = 0; i < static_cast<int>(cases().size()); ++i) {
    const StudyCase& one = cases()[i];
    const CaseState now = state(i);
    csv.text(one.name).text(kCaseStateNames[static_cast<std::size_t>(now)]);
    for (const std::string& word : one.inputs) csv.text(word);
    const Json result =
        now == CaseState::done ? read_json(case_folder(i) / "result.json") : Json::object();
    for (const std::string_view name : kNumbers)
      if (const auto found = result.find(name); found != result.end() && found->is_number())
        csv.number(found->get<double>());
      else
        csv.text("");
    csv.text(failure(i));
    csv.end_row();
  }
  csv.commit();
}

}  // namespace palpate::tools
