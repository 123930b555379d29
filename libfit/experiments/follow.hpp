#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <vector>

#include "libfit/core/probe.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/runtime/engine.hpp"

namespace palpate {

/// Longest move of a followed tool in a tick: 20 mm/s at 1 kHz.
inline constexpr double kWalkTick_m = 20e-6;
/// Share of the depth from which a followed tool comes to its first row, outside.
inline constexpr double kApproachRatio = 0.1;

/// An asset as indenters meet it (docs/method-tools.md, section 30), each tabulated once.
class IndenterAssets {
 public:
  explicit IndenterAssets(const runtime::AssetView& asset) : asset_(asset) {}
  IndenterAssets(const IndenterAssets&) = delete;
  IndenterAssets& operator=(const IndenterAssets&) = delete;

  /// Null: as it is, for its own ball, and where it does not say which ball that was.
  const runtime::AssetView* of(const Indenter& end);
  /// The same for the balls of a tool.
  void put_into(const std::vector<Indenter>& end, runtime::ToolShape& shape);

 private:
  struct MadeAsset {
    std::uint64_t mark;
    std::vector<std::uint64_t> memory;
    runtime::AssetView view;
  };
  const runtime::AssetView& asset_;
  std::deque<MadeAsset> entries_;
};

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

/// Answers to rows of samples, as columns beside theirs. torque_Nm: about the tool's point, where
/// an engine answered.
struct Replayed {
  Points force_N, torque_Nm;     ///< ON THE BODY; 0 where nothing was answered
  std::vector<char> is_sliding;  ///< the last tick of the row slipped
  std::vector<char> is_answered;
  std::vector<unsigned> flags;  ///< PALPATE_FLAG_... of the last tick
  std::size_t ticks = 0;        ///< of all tools that are on the body together

  explicit Replayed(const SampleRows& asked)
      : force_N(Points::Zero(asked.rows(), 3)),
        torque_Nm(force_N),
        is_sliding(asked.rows(), 0),
        is_answered(is_sliding),
        flags(asked.rows(), 0) {}
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
  explicit Follower(const runtime::AssetView& asset);
  Replayed follow(const Samples& samples, double depth_m, const PlayedAs& played_as = {},
                  const OnFollowed& on_row = {});

 private:
  runtime::AssetView view_;
  std::vector<std::uint64_t> body_;  ///< of its own, where contacts damage it
  IndenterAssets met_;               ///< tabulated when a tool is first followed
};
/// The same once.
Replayed follow(const runtime::AssetView& asset, const Samples& samples, double depth_m,
                const PlayedAs& played_as = {}, const OnFollowed& on_row = {});

/// The asset with another coupling, which must outlive it; none: contacts are by themselves.
runtime::AssetView coupled_by(const runtime::AssetView& asset,
                              const runtime::CouplingView& coupling);

/// Force of each good row that its error is divided by where experiments are weighed against each
/// other: its own, or where that is more relative_floor() of the largest of its tool in its
/// experiment. 0 of others.
Eigen::VectorXd row_scales_N(const Samples& samples);

}  // namespace palpate
