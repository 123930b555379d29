#include "libfit/validation/replay.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "libfit/core/experiments.hpp"
#include "libfit/fit/point/local_curves.hpp"
#include "libfit/validation/tick_time.hpp"

namespace palpate::validation {
namespace {

// Rows of each experiment of a point that can be replayed, in step order.
std::map<std::int32_t, std::vector<Eigen::Index>> usable_rows(const Samples& samples,
                                                              std::int32_t point) {
  std::map<std::int32_t, std::vector<Eigen::Index>> usable;
  std::map<std::int32_t, bool> has_ended;
  for (Eigen::Index row = 0; row < samples.rows(); ++row) {
    if (samples.point[row] != point) continue;
    const bool is_good = samples.status[row] == RowStatus::good;
    bool& ended = has_ended[samples.experiment[row]];
    if (is_good && !ended) usable[samples.experiment[row]].push_back(row);
    if (!is_good && samples.kind[row] != ExperimentKind::press) ended = true;
  }
  return usable;
}

}  // namespace

void replay_point(const Samples& samples, std::int32_t point, const CurveSet& curves,
                  Eigen::Index row, Replayed& replayed) {
  const fit::Bases bases = fit::bases_of(curves);
  const fit::LocalCurves local = fit::curves_at(bases, curves, row, samples, point);
  for (const auto& [experiment, rows] : usable_rows(samples, point)) {
    replayed.force_N(rows, Eigen::all) = fit::local_answer(local, samples, rows).force;
    for (const Eigen::Index i : rows) replayed.is_answered[i] = 1;
  }
}

double time_ticks_ns(const runtime::AssetView& asset, const Samples& paths, double depth_m,
                     const PlayedAs& played_as) {
  Follower follower(asset);
  std::vector<PlayedTool> tools;  // made once, as a simulator does
  for (Eigen::Index row = 0; played_as && row < paths.rows(); ++row)
    tools.push_back(played_as(row));
  const PlayedAs made = [&](Eigen::Index row) { return tools[row]; };
  const auto play = [&] {
    return follower.follow(paths, depth_m, played_as ? made : nullptr).ticks;
  };
  play();  // tables are made when tools are made
  return tick_ns(play);
}

}  // namespace palpate::validation
