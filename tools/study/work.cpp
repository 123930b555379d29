#include "tools/study/work.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "libfit/core/error.hpp"
#include "libfit/core/statistics.hpp"
#include "libfit/core/text.hpp"
#include "libfit/io/files/files.hpp"
#include "tools/build_identity.hpp"
#include "tools/console.hpp"
#include "tools/outputs.hpp"
#include "tools/scene/settings.hpp"
#include "tools/setup/trial.hpp"
#include "tools/stages/body/open_scene.hpp"
#include "tools/stages/body/prepare.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/run.hpp"
#include "tools/stages/samples/simulate.hpp"

namespace palpate::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kOtherStages_s = 30;  // merge, fit, refine, export, beside what is simulated

constexpr double kCopies = 3;     // of the surface's motion: read, joined, written
constexpr int kMaxRounds = 1000;  // of a case, more than any placement has

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
  std::vector<double> depth_m(static_cast<std::size_t>(samples.points()), 0), stiffness(depth_m);
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

std::string Work::text() const {
  const std::string_view name = kWorkNames[static_cast<std::size_t>(kind)];
  return kind == WorkKind::simulate
             ? fmt::format("{}:{}:{}/{}", name, item, shard.number, shard.count)
             : fmt::format("{}:{}", name, item);
}

Work Work::parse(const std::string& text) {
  for (std::size_t kind = 0; kind < kWorkNames.size(); ++kind) {
    const std::string name = std::string(kWorkNames[kind]) + ":";
    if (!text.starts_with(name)) continue;
    Work work{static_cast<WorkKind>(kind), std::atoi(text.c_str() + name.size())};
    if (work.kind == WorkKind::simulate) work.shard = parse_shard(text.substr(text.rfind(':') + 1));
    return work;
  }
  throw Error(text, "is no work of a study",
              "Let `palpate study resume` write what is to be done.");
}

Samples with_forces_times(Samples samples, double factor) {
  samples.force *= factor;
  samples.torque *= factor;
  samples.force_error *= factor;
  samples.point_sway /= factor;
  return samples;
}

void StudyFolder::plan(const fs::path& folder, const Study& study) {
  OutputFolder(folder).claim();
  fs::create_directories(folder / "cases");
  Json cases = Json::array();
  for (const StudyCase& one : study.cases) {
    const fs::path path = folder / "cases" / one.name;
    fs::create_directories(path);
    if (!fs::exists(path / "scene.toml")) write_file_atomically(path / "scene.toml", one.scene);
    const Scene scene = parse_scene(one.scene, path / "scene.toml");
    cases.push_back(
        {{"name", one.name},
         {"inputs", one.inputs},
         {"body", one.body},
         {"source", one.source},
         {"factor", one.factor},
         {"points",
          scene.experiments.placement ? kFirstPoints : scene.experiments.test_points.value_or(0)},
         {"max_points", scene.experiments.placement ? scene.experiments.placement->budget
                                                    : scene.experiments.test_points.value_or(0)},
         {"placed", scene.experiments.placement.has_value()},
         {"held_out", scene.validate.points + scene.validate.presses()}});
  }
  const ClusterSection& cluster = study.cluster;
  Json json{{"schema", "palpate-study"},
            {"program", build_identity()},
            {"study", study.path.string()},
            {"inputs", study.inputs},
            {"cluster",
             {{"task_min", cluster.task_min},
              {"point_min", cluster.point_min},
              {"memory_MB", cluster.memory_MB},
              {"time_factor", cluster.time_factor},
              {"max_array", cluster.max_array},
              {"command", cluster.command},
              {"options", cluster.options}}},
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
    study_.cluster = {cluster.at("task_min"),    cluster.at("point_min"), cluster.at("memory_MB"),
                      cluster.at("time_factor"), cluster.at("max_array"), cluster.at("command"),
                      cluster.at("options")};
    for (const Json& one : json.at("cases")) {
      study_.cases.push_back({one.at("name"), one.at("inputs"), "", one.at("body"),
                              one.at("source"), one.at("factor")});
      points_.push_back(one.at("points"));
      max_points_.push_back(one.at("max_points"));
      held_out_.push_back(one.at("held_out"));
      has_rounds_ = has_rounds_ || one.at("placed");
    }
  } catch (const Json::exception& e) {
    throw Error((path_ / "study.json").string(), fmt::format("is damaged: {}", e.what()),
                "Plan the study again; what is done is kept.");
  }
  if (fs::exists(path_ / "cost.json")) {
    const Json cost = read_json(path_ / "cost.json");
    cost_ = {cost.value("prepare_s", 0.0), cost.value("point_s", 0.0), cost.value("points", 0),
             cost.value("memory_MB", 0.0), cost.value("surface_MB", 0.0)};
  }
}

fs::path StudyFolder::case_folder(int number) const {
  return path_ / "cases" / study_.cases[static_cast<std::size_t>(number)].name;
}

void StudyFolder::measure() {
  if (cost_.point_s > 0) return;
  const ClusterSection& said = cluster();
  cost_ = {0, 60 * said.point_min, 0, said.memory_MB, 0};
  if (said.point_min == 0 || said.memory_MB == 0) {
    std::size_t pilot = 0;
    std::uintmax_t most = 0;
    for (std::size_t i = 0; i < cases().size(); ++i) {
      const Scene scene = open_scene(case_folder(static_cast<int>(i)) / "scene.toml");
      const std::uintmax_t bytes =
          fs::file_size(scene.body.surface ? *scene.body.surface : *scene.body.tetmesh);
      if (bytes > most) most = bytes, pilot = i;
    }
    say("pilot: one point of case {} ({})", pilot + 1, listed(cases()[pilot].inputs));
    const fs::path folder = case_folder(static_cast<int>(pilot));
    const double from_s = wall_seconds();
    prepare(cases()[pilot].body);
    cost_.prepare_s = wall_seconds() - from_s;
    const Body body = read_body(folder / "body.h5");
    const Scene scene = scene_of(body, folder / "body.h5");
    const Trial trial = try_middle_point(scene, body);
    if (said.point_min == 0) cost_.point_s = trial.cpu_s;
    if (said.memory_MB == 0) {
      cost_.memory_MB = peak_MB();
      if (surface_columns(scene, body) > 0)
        cost_.surface_MB = 1e-6 * sizeof(float) * static_cast<double>(trial.rows) *
                           static_cast<double>(body.surface.vertices.size());
    }
    cost_.points = static_cast<int>(body.test_points.position.rows());
    say("pilot: {} a point on one processor, {:.0f} MB", in_words(cost_.point_s), cost_.memory_MB);
  }
  write_json(path_ / "cost.json", {{"prepare_s", cost_.prepare_s},
                                   {"point_s", cost_.point_s},
                                   {"points", cost_.points},
                                   {"memory_MB", cost_.memory_MB},
                                   {"surface_MB", cost_.surface_MB}});
}

int StudyFolder::rounds() const {
  int rounds = 0;
  for (int i = 0; has_rounds_ && i < static_cast<int>(cases().size()); ++i) {
    const fs::path round = case_folder(i) / "round.json";
    if (fs::exists(round)) rounds += read_json(round).at("round").get<int>();
    if (fs::exists(case_folder(i) / "samples.h5")) rounds += kMaxRounds;
  }
  return rounds;
}

// Points, or experiments of a later round, that the case simulates next.
int StudyFolder::round_points(int number) const {
  const fs::path round = case_folder(number) / "round.json";
  if (fs::exists(round)) return static_cast<int>(read_json(round).at("experiments").size());
  const int known = points_[static_cast<std::size_t>(number)];
  return std::max(1, known > 0 ? known : cost_.points);
}

// As many as make a shard as long as a task shall be; one where that is not known.
int StudyFolder::shards(int number) const {
  const int points = round_points(number);
  const double tasks = points * cost_.point_s / (60 * cluster().task_min);
  return std::clamp(static_cast<int>(std::ceil(tasks)), 1, points);
}

std::vector<Work> StudyFolder::missing(WorkKind kind) const {
  std::vector<Work> out;
  std::set<int> bodies;
  for (int i = 0; i < static_cast<int>(cases().size()); ++i) {
    const StudyCase& one = cases()[static_cast<std::size_t>(i)];
    const fs::path folder = case_folder(i);
    const auto lacks = [&](const char* name) { return !fs::exists(folder / name); };
    if (kind == WorkKind::prepare && lacks("body.h5") && bodies.insert(one.body).second)
      out.push_back({kind, one.body});
    if (kind == WorkKind::merge && one.source == i && lacks("samples.h5")) out.push_back({kind, i});
    if (kind == WorkKind::finish && lacks("result.json")) out.push_back({kind, i});
    if (kind != WorkKind::simulate || one.source != i || !lacks("samples.h5")) continue;
    const int count = shards(i);
    for (int number = 1; number <= count; ++number)
      if (!fs::exists(shard_path(folder, {number, count})))
        out.push_back({kind, i, {number, count}});
  }
  return out;
}

double StudyFolder::expected_s(const Work& work) const {
  const auto item = static_cast<std::size_t>(work.item);
  switch (work.kind) {
    case WorkKind::prepare:
      return kOtherStages_s + cost_.prepare_s;
    case WorkKind::simulate:
      return cost_.point_s * std::ceil(double(round_points(work.item)) / work.shard.count);
    case WorkKind::finish:
      return kOtherStages_s + cost_.point_s * held_out_[item];
    default:
      return kOtherStages_s;
  }
}

double StudyFolder::expected_MB(const Work& work) const {
  if (work.kind == WorkKind::prepare) return cost_.memory_MB;
  const int known = max_points_[static_cast<std::size_t>(work.item)];
  const double points = work.kind == WorkKind::simulate
                            ? std::ceil(double(round_points(work.item)) / work.shard.count)
                            : std::max(known, cost_.points);
  return cost_.memory_MB + kCopies * cost_.surface_MB * points;
}

std::vector<int> StudyFolder::cases_of(const Work& work) const {
  if (work.kind != WorkKind::prepare) return {work.item};
  std::vector<int> numbers;
  for (std::size_t i = 0; i < cases().size(); ++i)
    if (cases()[i].body == work.item) numbers.push_back(static_cast<int>(i));
  return numbers;
}

bool StudyFolder::work(const Work& work, int jobs) const {
  try {
    switch (work.kind) {
      case WorkKind::prepare:
        prepare(work.item);
        break;
      case WorkKind::simulate:
        simulate_shard(case_folder(work.item), work.shard, jobs);
        break;
      case WorkKind::merge:
        merge(work.item, jobs);
        break;
      case WorkKind::finish:
        finish(work.item, jobs);
        break;
    }
    return true;
  } catch (const Error& e) {
    say_failed("{}: {}", work.text(), e.what());
    for (const int number : cases_of(work))
      if (failure(number).empty())  // the first says why; what needs it fails as well
        write_file_atomically(case_folder(number) / "error.txt",
                              fmt::format("{}: {}\n", work.text(), e.what()));
    return false;
  }
}

void StudyFolder::prepare(int body) const {
  std::optional<Body> prepared;
  for (const int number : cases_of({WorkKind::prepare, body})) {
    const fs::path folder = case_folder(number);
    if (fs::exists(folder / "body.h5")) continue;
    const Scene scene = open_scene(folder / "scene.toml");
    if (!prepared) prepared = prepare_body(scene, false);
    check_experiments(scene, *prepared);
    settle_body(folder, scene, *prepared, body_fingerprint(scene));
  }
}

void StudyFolder::merge(int number, int jobs) const {
  const fs::path folder = case_folder(number), output = folder / "samples.h5";
  const OutputLock lock(output);
  if (fs::exists(output)) return;
  const Merged merged = merge_shards(folder, output, jobs);
  const fs::path cost = folder / "cost.json";
  const double before_s = fs::exists(cost) ? read_json(cost).value("cpu_s", 0.0) : 0;
  write_json(cost, {{"cpu_s", before_s + merged.cpu_s}});
  if (!merged.samples)
    say("case {}: round {} has {} experiments", number + 1, merged.next_round,
        merged.next_experiments);
}

void StudyFolder::finish(int number, int jobs) const {
  const StudyCase& one = cases()[static_cast<std::size_t>(number)];
  const fs::path folder = case_folder(number), output = folder / "samples.h5";
  if (fs::exists(folder / "result.json")) return;
  if (fs::exists(folder / "round.json")) return;  // its next round comes first
  const std::clock_t from = std::clock();
  if (one.source != number && !fs::exists(output)) {
    const fs::path from_case = case_folder(one.source) / "samples.h5";
    const Body body = read_body(folder / "body.h5");
    const Scene scene = scene_of(body, folder / "body.h5");
    say("case {}: forces of case {} times {:.6g}", number + 1, one.source + 1, one.factor);
    write_with_surface(
        output,
        with_forces_times(surface_columns(scene, body) > 0 ? read_with_surface(from_case)
                                                           : read_samples(from_case),
                          one.factor),
        {{kInputsAttribute, samples_fingerprint(scene, body)},
         {"scaled_from", study_.cases[static_cast<std::size_t>(one.source)].name},
         {"scaled_by", to_text(one.factor)}});
  }
  if (!fs::exists(output))
    throw Error(output.string(), "is not there yet",
                fmt::format("Simulate what lacks: palpate study resume {}.", path_.string()));
  const RunResult run =
      run_stages({(folder / "scene.toml").string(), folder.string(), jobs, false, false});
  const Samples samples = read_samples(output);
  const fs::path cost = folder / "cost.json";
  const double simulated_s = fs::exists(cost) ? read_json(cost).value("cpu_s", 0.0) : 0;
  write_json(folder / "result.json",
             {{"name", listed(one.inputs)},
              {"points", samples.points()},
              {"rows", samples.rows()},
              {"items_failed", run.items_failed},
              {"median_rel", run.statement.all.force.median_rel},
              {"p95_rel", run.statement.all.force.p95_rel},
              {"max_rel", run.statement.all.force.max_rel},
              {"within_jnd", run.statement.within_jnd},
              {"reference_p95_rel", run.statement.reference_p95_rel},
              {"stiffness_N_m", median_stiffness(samples)},
              {"cpu_s", simulated_s + double(std::clock() - from) / CLOCKS_PER_SEC},
              {"memory_MB", peak_MB()}});
  std::error_code ignored;
  fs::remove(folder / "error.txt", ignored);
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

}  // namespace palpate::tools
