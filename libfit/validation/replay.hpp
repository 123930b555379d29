#pragma once

#include <functional>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/experiments/draw.hpp"
#include "libfit/experiments/follow.hpp"
#include "libfit/validation/statement.hpp"

namespace palpate::validation {

/// What an asset is compared with.
struct Reference {
  HeldOut held_out;
  Samples paths;  ///< simulated along held_out.paths; the place of a row is its path's number
  Samples own;    ///< presses and drags at held-out points themselves; empty unless wanted
};

/// What was answered to reference rows, row for row.
struct Replayed {
  Points force_N;                ///< ON THE BODY; 0 where nothing was replayed
  Points torque_Nm;              ///< of that force about the tip, where an engine answered
  std::vector<char> is_sliding;  ///< the last tick of the row slipped
  std::vector<char> is_answered;

  explicit Replayed(const Samples& reference);
};

/// A held-out path with the engine (follow.hpp). Answers the path's rows.
void replay_path(const runtime::AssetView& asset, const Reference& reference, std::size_t path,
                 double depth_m, Replayed& replayed);

/// Rows of any kinds with the engine, as follow() plays them.
Replayed replay(const runtime::AssetView& asset, const Samples& reference, double depth_m,
                const PlayedAs& played_as = {});

/// The experiments of one point with given curves: the law of section 4 on the local quadric
/// (docs/method.md, M11), as the fit sees it. row: of `curves`. Answers the point's good rows; of a
/// drag or path those before its first row that is not.
void replay_point(const Samples& samples, std::int32_t point, const CurveSet& curves,
                  Eigen::Index row, Replayed& replayed);

/// Good reference rows with what was answered. counts: whether a row does; by default all.
std::vector<ComparedRow> compare(
    const Samples& reference, const Points& answer_N,
    const std::function<bool(Eigen::Index)>& counts = [](Eigen::Index) { return true; });

/// Good reference rows that were replayed.
std::vector<ComparedRow> compare(const Samples& reference, const Replayed& replayed);

/// The same with torques about the centre of a ball of radius_m, where only friction turns it; 0:
/// about the tool's point (M58a).
std::vector<ComparedRow> compare_torques(
    const Samples& reference, const Replayed& replayed, double radius_m,
    const std::function<bool(Eigen::Index)>& counts = [](Eigen::Index) { return true; });

/// Time of a tick on this machine over repeated replays of all paths [ns] (tick_time.hpp).
double time_ticks_ns(const runtime::AssetView& asset, const Samples& paths, double depth_m,
                     const PlayedAs& played_as = {});

}  // namespace palpate::validation
