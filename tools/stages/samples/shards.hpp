#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tools/scene/scene.hpp"
#include "tools/stages/samples/sample_cache.hpp"

namespace palpate::tools {

// Experiments of one scene simulated by several processes, which share a folder and nothing else:
//
//   body.h5                  body and scene; the first process makes it, all others read it
//   round.h5, merged.h5    points that place themselves: what a merge wants next, what it has
//   shard-3-of-8.h5          what process 3 of 8 simulated (.partial while it is at it)
//
// A merge puts all shards of a round together, and has the bytes that one process would have.

/// One of `count` processes, numbered from 1.
struct Shard {
  int number = 1, count = 1;
};

/// "3/8". Throws Error at --shard.
Shard parse_shard(const std::string& text);

std::filesystem::path shard_path(const std::filesystem::path& folder, const Shard& shard);

/// Cost of an experiment, in rows of a press on two meshes.
double cost_of(const Experiment& experiment, const fem::Experiments& each);

/// Numbers of the experiments that a shard simulates, ascending: the costliest first, each to
/// the shard that has least so far, so that all take equally long. Each goes to one shard.
/// Source: Graham, Bounds on multiprocessing timing anomalies (1969): longest processing time
/// first.
std::vector<std::size_t> dealt_to(const Shard& shard, const ExperimentList& list,
                                  const fem::Experiments& each);

/// Simulates a shard's experiments, or those an interrupted process left of them, and writes its
/// file. Writes nothing where that is up to date. Returns how many there are. Throws Error when the
/// folder's body.h5 is of another scene, or another process simulates this shard.
std::size_t simulate_shard(const std::filesystem::path& folder, const Shard& shard, int jobs);

/// The body of a folder of shards, written there first where it has none. fingerprint: of the body
/// (body_fingerprint). Throws Error where the folder has one of another scene.
void settle_body(const std::filesystem::path& folder, const Scene& scene, const Body& body,
                 const std::string& fingerprint);

/// Result of merging: samples, or one more round to simulate.
struct Merged {
  std::optional<Samples> samples;
  int next_round = 0;
  std::size_t next_experiments = 0;
};

/// Puts the shards of a folder together. Where points place themselves and more are wanted, writes
/// merged.h5 and round.h5 instead of the output, and removes the shards of the round.
/// Throws Error at a shard of another scene, version or round's points, at shards of several
/// counts, and naming those that are missing.
Merged merge_shards(const std::filesystem::path& folder, const std::filesystem::path& output,
                    int jobs);

}  // namespace palpate::tools
