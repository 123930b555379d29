#include "tools/stages/samples/shards.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"
#include "tools/console.hpp"
#include "tools/outputs.hpp"
#include "tools/scene/canonical.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/samples/experiment_table.hpp"
#include "tools/stages/samples/placement.hpp"

namespace palpate::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// Root attributes of a shard's file.
constexpr const char* kShard = "shard";
constexpr const char* kRound = "round";
constexpr const char* kProgram = "program_hash";
constexpr const char* kQuick = "quick";

struct Settled {
  Body body;
  Scene scene;
};

// The experiments of a round: all that need nothing else first, or in later rounds what round.h5
// says.
struct ShardRound {
  int number = 0;
  ExperimentBatch batch;
};

Settled read_settled(const fs::path& folder) {
  Settled settled{read_body(folder / "body.h5"), {}};
  settled.scene = scene_of(settled.body, folder / "body.h5");
  return settled;
}

std::string name_of(const Shard& shard) { return fmt::format("{}/{}", shard.number, shard.count); }

Attributes attributes_of(const Settled& settled, const Shard& shard, int round) {
  return {{kInputsAttribute, samples_fingerprint(settled.scene, settled.body)},
          {kPointFingerprintAttribute, point_fingerprint(settled.scene, settled.body)},
          {kToolFingerprintAttribute, tool_fingerprint(settled.scene, settled.scene.pressed)},
          {kShard, name_of(shard)},
          {kRound, std::to_string(round)},
          {kProgram, import_fingerprint()}};
}

// True if a file has all these attributes.
bool carries(const Attributes& stored, const Attributes& wanted) {
  return std::all_of(wanted.begin(), wanted.end(), [&](const auto& attribute) {
    const auto found = stored.find(attribute.first);
    return found != stored.end() && found->second == attribute.second;
  });
}

Attributes attributes_in(const fs::path& path) {
  try {
    return read_attributes(path);
  } catch (const Error&) {  // missing or damaged
    return {};
  }
}

Json to_json(const fem::QuickScale& quick) {
  Json json{{"steps", Json::array()}, {"slope", quick.slope}, {"p95", quick.p95}};
  for (const fem::QuickStep& step : quick.steps)
    json["steps"].push_back({step.scale, step.log_force, step.lowest, step.highest, step.error});
  return json;
}
fem::QuickScale quick_of(const Json& json) {
  fem::QuickScale quick{{}, json.at("slope"), json.at("p95")};
  for (const Json& step : json.at("steps"))
    quick.steps.push_back({step.at(0), step.at(1), step.at(2), step.at(3), step.at(4)});
  return quick;
}

void write_round(const fs::path& path, const ShardRound& round, const std::string& fingerprint) {
  Samples planned = planned_rows(round.batch.list);
  for (const std::int32_t number : planned.probe_number)
    planned.other_probes.resize(std::max<std::size_t>(planned.other_probes.size(), number));
  write_samples(path, planned,
                {{kInputsAttribute, fingerprint},
                 {kRound, std::to_string(round.number)},
                 {kQuick, to_json(round.batch.quick).dump()}});
}

std::optional<ShardRound> read_round(const fs::path& path, const std::string& fingerprint) {
  if (stored_in_hdf5(path) != fingerprint) return std::nullopt;  // none, or of an earlier scene
  try {
    const Attributes stored = read_attributes(path);
    return ShardRound{std::stoi(stored.at(kRound)),
                      {list_of(read_samples(path)), quick_of(Json::parse(stored.at(kQuick)))}};
  } catch (const std::exception& e) {
    throw Error(path.string(), fmt::format("is no round of shards: {}", e.what()),
                "Delete it and merged.h5; the rounds then start again.");
  }
}

ShardRound round_of(const fs::path& folder, const Settled& settled) {
  if (auto round =
          read_round(folder / "round.h5", samples_fingerprint(settled.scene, settled.body)))
    return *std::move(round);
  try {
    SimulateRequest request;
    request.only_known = true;
    simulate_scene(settled.scene, settled.body, request, Samples{});
  } catch (ExperimentsMissing& missing) {
    return {0, std::move(missing.batch)};
  }
  return {};  // a body without test points, which prepare refuses
}

// Finds the shards of a folder by their names.
std::map<std::pair<int, int>, fs::path> shards_in(const fs::path& folder) {
  std::map<std::pair<int, int>, fs::path> found;
  for (const auto& entry : fs::directory_iterator(folder)) {
    int number = 0, count = 0, end = 0;
    const std::string name = entry.path().filename().string();
    if (std::sscanf(name.c_str(), "shard-%d-of-%d.h5%n", &number, &count, &end) == 2 &&
        static_cast<std::size_t>(end) == name.size())
      found[{count, number}] = entry.path();
  }
  return found;
}

void remove_shards(const fs::path& folder) {
  for (const auto& [_, path] : shards_in(folder)) {
    std::error_code ignored;
    fs::remove(surface_path(path), ignored);
    fs::remove(path, ignored);
  }
}

std::string again(const fs::path& folder, const Shard& shard) {
  return fmt::format("palpate simulate {} --shard {} -o {}", (folder / "body.h5").string(),
                     name_of(shard), folder.string());
}

// Number of shards of the round, all of which must be there.
int check_complete(const fs::path& folder) {
  const auto found = shards_in(folder);
  if (found.empty())
    throw Error(folder.string(), "holds no shard of this round",
                fmt::format("Simulate all of them: {}.", again(folder, {1, 1})));
  const int count = found.begin()->first.first, other = found.rbegin()->first.first;
  if (count != other)
    throw Error(folder.string(),
                fmt::format("holds shards of {} and of {}, which share the points differently",
                            count, other),
                fmt::format("Delete those of one of the two: shard-*-of-{}.h5 or shard-*-of-{}.h5.",
                            count, other));
  std::vector<std::string> missing;
  Shard first{0, count};
  for (int number = 1; number <= count; ++number)
    if (!found.contains({count, number})) {
      if (first.number == 0) first.number = number;
      missing.push_back(name_of({number, count}) +
                        (fs::exists(shard_path(folder, {number, count}).string() + ".partial")
                             ? " (unfinished)"
                             : ""));
    }
  if (!missing.empty())
    throw Error(folder.string(),
                fmt::format("lacks {} of {} shards: {}", missing.size(), count, listed(missing)),
                fmt::format("Simulate them: {}{}.", again(folder, first),
                            missing.size() > 1 ? ", and so on" : ""));
  return count;
}

// A shard's samples, which must be those of its points, all of them and no others.
Samples read_shard(const fs::path& folder, const Settled& settled, const ShardRound& round,
                   const Shard& shard) {
  const fs::path path = shard_path(folder, shard);
  const Attributes stored = read_attributes(path);
  const Attributes wanted = attributes_of(settled, shard, round.number);
  const auto differs = [&](const char* key) { return !carries(stored, {{key, wanted.at(key)}}); };
  const char* what = differs(kProgram)           ? "was simulated by another version of palpate"
                     : differs(kInputsAttribute) ? "was simulated from another scene than body.h5"
                     : differs(kShard) ? "is another shard than its name says, so points come twice"
                     : differs(kRound) ? "is of another round of the placement"
                                       : nullptr;
  if (what) throw Error(path.string(), what, "Simulate it again: " + again(folder, shard) + ".");
  const fem::Experiments each = experiments_of(settled.scene);
  const ExperimentList own = taken(round.batch.list, dealt_to(shard, round.batch.list, each));
  if (own.size() == 0) return {};  // more shards than experiments
  Samples samples = read_samples(path);
  if (samples.point_position != own.places.position || samples.point_normal != own.places.normal ||
      !without_rows(own, samples, fem::experiments_per_point(each)).empty())
    throw Error(path.string(), "does not hold the experiments of its shard",
                "Simulate it again: " + again(folder, shard) + ".");
  if (surface_columns(settled.scene, settled.body) > 0)
    read_surface_motion(surface_path(path), samples);
  return samples;
}

// One after another, by halves: each row is copied few times.
Samples joined_all(std::vector<Samples> parts) {
  for (; parts.size() > 1; parts.resize((parts.size() + 1) / 2))
    for (std::size_t i = 0; i < parts.size(); i += 2)
      parts[i / 2] = i + 1 < parts.size() ? joined(parts[i], parts[i + 1]) : std::move(parts[i]);
  return std::move(parts.front());
}

}  // namespace

Shard parse_shard(const std::string& text) {
  Shard shard;
  const char* const end = text.data() + text.size();
  const auto [slash, bad] = std::from_chars(text.data(), end, shard.number);
  const bool has_slash = bad == std::errc() && slash != end && *slash == '/';
  if (!has_slash || std::from_chars(slash + 1, end, shard.count).ptr != end || shard.number < 1 ||
      shard.number > shard.count)
    throw Error("--shard", fmt::format("\"{}\" is no shard", text),
                "Give its number and how many there are, such as 3/8; numbers start at 1.");
  return shard;
}

fs::path shard_path(const fs::path& folder, const Shard& shard) {
  return folder / fmt::format("shard-{}-of-{}.h5", shard.number, shard.count);
}

double cost_of(const Experiment& experiment, const fem::Experiments& each) {
  if (experiment.kind != ExperimentKind::press)
    return static_cast<double>(experiment.path.deflections.rows());
  const double press = each.press_steps;
  if (experiment.effort.scale > 0) return 0.35 * press;  // on one mesh (docs/cluster.md)
  return experiment.effort.is_dragged
             ? press + double(fem::experiments_per_point(each) - 1) * each.drag_steps
             : press;
}

std::vector<std::size_t> dealt_to(const Shard& shard, const ExperimentList& list,
                                  const fem::Experiments& each) {
  std::vector<double> cost;
  for (const Experiment& one : list.experiments) cost.push_back(cost_of(one, each));
  std::vector<std::size_t> order(cost.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::greater(), [&](std::size_t i) { return cost[i]; });
  std::vector<double> load(shard.count, 0);
  std::vector<std::size_t> own;
  for (const std::size_t i : order) {
    const auto least = std::min_element(load.begin(), load.end());
    *least += cost[i];
    if (least - load.begin() == shard.number - 1) own.push_back(i);
  }
  std::sort(own.begin(), own.end());
  return own;
}

void settle_body(const fs::path& folder, const Scene& scene, const Body& body,
                 const std::string& fingerprint) {
  const fs::path path = folder / "body.h5";
  if (!fs::exists(path)) {
    Body settled = body;
    store_scene(scene, settled);
    std::error_code ignored;
    fs::create_directories(folder, ignored);
    write_body(path, settled, {{kInputsAttribute, fingerprint}});
    return;
  }
  const Settled there = read_settled(folder);
  if (samples_fingerprint(there.scene, there.body) != samples_fingerprint(scene, body))
    throw Error(folder.string(), "holds shards of another scene",
                "Choose another folder, or delete this one.");
}

std::size_t simulate_shard(const fs::path& folder, const Shard& shard, int jobs) {
  const fs::path path = shard_path(folder, shard);
  const OutputLock lock(path);
  const Settled settled = read_settled(folder);
  const ShardRound round = round_of(folder, settled);
  const fem::Experiments each = experiments_of(settled.scene);
  const ExperimentList own = taken(round.batch.list, dealt_to(shard, round.batch.list, each));
  const Attributes attributes = attributes_of(settled, shard, round.number);
  if (carries(attributes_in(path), attributes)) {
    say("{} is up to date", path.string());
    return own.size();
  }
  const SimulateRequest request =
      request_for(settled.scene, settled.body, Purpose::identify, jobs, path);
  const Simulators simulators(settled.scene, settled.body, Purpose::identify);
  const Samples samples =
      own.size() == 0 ? Samples()
                      : SampleCache(request).at(std::cref(simulators), own, each,
                                                "shard " + name_of(shard), round.batch.quick);
  write_with_surface(path, samples, attributes);
  remove_partial(path);
  return own.size();
}

Merged merge_shards(const fs::path& folder, const fs::path& output, int jobs) {
  const Settled settled = read_settled(folder);
  const std::string fingerprint = samples_fingerprint(settled.scene, settled.body);
  const ShardRound round = round_of(folder, settled);
  // Shards that a merge had put together when it was interrupted.
  for (const auto& [_, path] : shards_in(folder)) {
    const Attributes stored = attributes_in(path);
    if (round.number > 0 && carries(stored, {{kInputsAttribute, fingerprint},
                                             {kRound, std::to_string(round.number - 1)}}))
      fs::remove(path);
  }
  Merged merged;
  const bool has_surface = surface_columns(settled.scene, settled.body) > 0;
  if (shards_in(folder).empty() && stored_in_hdf5(output) == fingerprint &&
      (!has_surface || stored_in_hdf5(surface_path(output)) == fingerprint)) {
    say("{} is up to date", output.string());
    merged.samples = read_samples(output);
    return merged;
  }
  const int count = check_complete(folder);
  std::vector<Samples> parts;
  const fs::path earlier = folder / "merged.h5";
  if (round.number > 0)
    parts.push_back(has_surface ? read_with_surface(earlier) : read_samples(earlier));
  for (int number = 1; number <= count; ++number)
    if (Samples part = read_shard(folder, settled, round, {number, count}); part.rows() > 0)
      parts.push_back(std::move(part));
  SimulateRequest request =
      request_for(settled.scene, settled.body, Purpose::identify, jobs, output);
  request.only_known = true;
  Samples known = joined_all(std::move(parts));
  try {
    merged.samples = simulate_scene(settled.scene, settled.body, request, known);
  } catch (ExperimentsMissing& missing) {
    merged.next_round = round.number + 1;
    merged.next_experiments = missing.batch.list.size();
    write_with_surface(earlier, known, {{kInputsAttribute, fingerprint}});
    write_round(folder / "round.h5", {merged.next_round, std::move(missing.batch)}, fingerprint);
  }
  remove_shards(folder);
  if (merged.samples) {
    std::error_code ignored;
    for (const fs::path& done : {folder / "round.h5", surface_path(earlier), earlier})
      fs::remove(done, ignored);
  }
  return merged;
}

}  // namespace palpate::tools
