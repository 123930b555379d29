#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "libfit/core/samples.hpp"
#include "libfit/experiments/met_assets.hpp"
#include "libfit/experiments/walk.hpp"
#include "libfit/runtime/engine.hpp"

namespace palpate {

/// A tool as the engine plays it, and how it stands: its axes in the body's, and the point of it
/// that deflections and torques are of. By default an upright tip. end: how each ball meets the
/// body; none: as the ball that the asset was measured with.
struct PlayedTool {
  runtime::ToolShape shape;
  Stance stance;
  std::vector<Indenter> end = {};
};
/// Which tool made a row, by the row's number.
using PlayedAs = std::function<PlayedTool(Eigen::Index row)>;

/// What the engine answered to rows of samples, row for row. torque_Nm: about the tool's point.
struct FollowedRows {
  Points force_N, torque_Nm;     ///< ON THE BODY
  std::vector<char> is_sliding;  ///< the last tick of the row slipped
  std::size_t ticks = 0;         ///< of all tools that are on the body together
};
/// Called after each row with the tool that made it.
using OnFollowed = std::function<void(Eigen::Index row, const runtime::Tool& tool)>;

/// Experiments of any kind along the engine, each on a body that nothing has touched. Tools come
/// from a tenth of depth_m outside, of a drag straight down to its depth first, and go from row to
/// row in ticks of 20 um at most (20 mm/s at 1 kHz). Rows with times are followed in their time, of
/// a millisecond a tick at most; those without so slowly that dashpots of a body that relaxes do.
/// A tool of several balls is balls by themselves where the asset's contacts do not feel each
/// other. A status but ok answers with zero force.
class Follower {
 public:
  explicit Follower(const runtime::AssetView& asset) : body_(asset), met_(body_.fresh()) {}
  FollowedRows follow(const Samples& samples, double depth_m, const PlayedAs& played_as = {},
                      const OnFollowed& on_row = {});

 private:
  WalkedBody body_;
  MetAssets met_;  ///< tabulated when a tool is first followed
};
/// The same once.
FollowedRows follow(const runtime::AssetView& asset, const Samples& samples, double depth_m,
                    const PlayedAs& played_as = {}, const OnFollowed& on_row = {});

/// The asset with another coupling, which must outlive it; none: contacts are by themselves.
runtime::AssetView coupled_by(const runtime::AssetView& asset,
                              const runtime::CouplingView& coupling);

/// Of good rows, the force that its error is over where experiments are weighed against each other:
/// its own, or where that is more relative_floor() of the largest of its tool in its experiment. 0
/// of others.
Eigen::VectorXd row_scales_N(const Samples& samples);

}  // namespace palpate
