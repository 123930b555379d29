#include "libfit/experiments/follow.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "libfit/core/stated_error.hpp"

namespace palpate {
namespace {

// Tools that are on a body together, and where the point of each is.
class ToolsWalk {
 public:
  ToolsWalk(const runtime::AssetView& asset, IndenterAssets& met, std::vector<PlayedTool> played,
            std::vector<Vec3> places)
      : asset_(asset), played_(std::move(played)), at_(std::move(places)) {
    const bool is_apart = asset.coupling == nullptr;
    for (std::size_t i = 0; i < played_.size(); ++i) {
      met.put_into(played_[i].end, played_[i].shape);
      const runtime::ToolShape& shape = played_[i].shape;
      first_.push_back(tools_.size());
      if (!is_apart) {
        tools_.emplace_back().shape = shape;
        continue;
      }
      for (int k = 0; k < shape.balls; ++k) {
        tools_.emplace_back().shape = shape;
        tools_.back().shape.balls = 1;
        tools_.back().shape.ball[0] = shape.ball[k];
      }
    }
    first_.push_back(tools_.size());
    in_.resize(tools_.size());
    out_.resize(tools_.size());
    for (std::size_t i = 0; i < played_.size(); ++i)
      for (std::size_t k = first_[i]; k < first_[i + 1]; ++k) {
        const Eigen::Quaterniond turn(played_[i].stance.axes);
        double* q = in_[k].pose.orientation;
        q[0] = turn.w(), q[1] = turn.x(), q[2] = turn.y(), q[3] = turn.z();
      }
    tick(runtime::kMaxTimeStep_s);
  }

  const std::vector<Vec3>& places() const { return at_; }

  // dt_s: of the path; not finite: in slow motion.
  void go(const std::vector<Vec3>& to, double dt_s) {
    const std::vector<Vec3> from = at_;
    double path_m = 0;
    for (std::size_t i = 0; i < to.size(); ++i) path_m = std::max(path_m, (to[i] - from[i]).norm());
    const bool is_timed = std::isfinite(dt_s);
    const int steps = static_cast<int>(
        std::ceil(std::max({1.0, path_m / kWalkTick_m, is_timed ? dt_s / 1e-3 : 0})));
    for (int k = 1; k <= steps; ++k) {
      for (std::size_t i = 0; i < to.size(); ++i)
        at_[i] = from[i] + (to[i] - from[i]) * (double(k) / steps);
      tick(is_timed ? std::max(dt_s / steps, runtime::kMinTimeStep_s) : runtime::kMaxTimeStep_s);
    }
  }

  Vec3 force_N(std::size_t tool) const {
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = first_[tool]; k < first_[tool + 1]; ++k)
      sum -= Vec3::Map(out_[k].force_on_tool_N);
    return sum;
  }
  Vec3 torque_Nm(std::size_t tool) const {
    const Stance& stance = played_[tool].stance;
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = first_[tool]; k < first_[tool + 1]; ++k)
      sum -= Vec3::Map(out_[k].torque_on_tool_Nm);
    return sum - (stance.axes * stance.touch_m).cross(force_N(tool));
  }
  bool is_sliding(std::size_t tool) const {
    for (std::size_t k = first_[tool]; k < first_[tool + 1]; ++k)
      if (out_[k].state == runtime::ContactState::slip) return true;
    return false;
  }
  unsigned flags(std::size_t tool) const {
    unsigned all = 0;
    for (std::size_t k = first_[tool]; k < first_[tool + 1]; ++k) all |= out_[k].flags;
    return all;
  }
  const runtime::Tool& tool(std::size_t i) const { return tools_[first_[i]]; }
  std::size_t ticks() const { return ticks_; }

 private:
  void tick(double dt_s) {
    for (std::size_t i = 0; i < played_.size(); ++i)
      for (std::size_t k = first_[i]; k < first_[i + 1]; ++k) {
        Eigen::Map<Vec3>(in_[k].pose.position_m) =
            at_[i] - played_[i].stance.axes * played_[i].stance.touch_m;
        in_[k].dt_s = dt_s;
      }
    runtime::Tool* all[runtime::kMaxContacts];
    runtime::Status status[runtime::kMaxContacts];
    for (std::size_t k = 0; k < tools_.size(); ++k) all[k] = &tools_[k];
    touch_tools(asset_, all, in_.data(), out_.data(), status, static_cast<int>(tools_.size()));
    ++ticks_;
  }

  const runtime::AssetView& asset_;
  std::vector<PlayedTool> played_;
  std::vector<Vec3> at_;
  std::vector<std::size_t> first_;    // of tools_, of each that is played
  std::vector<runtime::Tool> tools_;  // or its balls, where none feels another
  std::vector<runtime::ToolInput> in_;
  std::vector<runtime::ToolOutput> out_;
  std::size_t ticks_ = 0;
};

// Rows of an experiment at one time: one of each tool.
Eigen::Index tools_at(const Samples& samples, Eigen::Index row) {
  Eigen::Index next = row + 1;
  while (next < samples.rows() && samples.experiment[next] == samples.experiment[row] &&
         samples.step[next] == samples.step[row])
    ++next;
  return next - row;
}

}  // namespace

const runtime::AssetView* IndenterAssets::of(const Indenter& end) {
  const double own_m = asset_.probe_radius_m;
  if (!runtime::knows_radius(asset_) || !runtime::is_possible(end)) return nullptr;
  if (end.points == 0 && std::abs(end.round_end_m - own_m) <= runtime::kSameRadius * own_m)
    return nullptr;
  const std::uint64_t mark = runtime::mark_of(end);
  for (const MadeAsset& entry : entries_)
    if (entry.mark == mark) return &entry.view;
  MadeAsset& made = entries_.emplace_back();
  made.mark = mark;
  made.memory.resize(runtime::indenter_bytes(asset_) / sizeof(std::uint64_t));
  made.view = runtime::with_indenter(asset_, end, made.memory.data());
  return &made.view;
}

void IndenterAssets::put_into(const std::vector<Indenter>& end, runtime::ToolShape& shape) {
  for (int i = 0; i < shape.balls && i < static_cast<int>(end.size()); ++i)
    shape.ball[i].asset = of(end[i]);
}

Replayed follow(const runtime::AssetView& asset, const Samples& samples, double depth_m,
                const PlayedAs& played_as, const OnFollowed& on_row) {
  return Follower(asset).follow(samples, depth_m, played_as, on_row);
}

Follower::Follower(const runtime::AssetView& asset)
    : view_(asset),
      body_(asset.damage.softens() ? runtime::body_bytes(asset) / 8 : 0),
      met_(view_) {
  if (!body_.empty()) view_ = runtime::with_body(asset, body_.data());
}

Replayed Follower::follow(const Samples& samples, double depth_m, const PlayedAs& played_as,
                          const OnFollowed& on_row) {
  Replayed out(samples);
  out.is_answered.assign(samples.rows(), 1);
  for (Eigen::Index row = 0; row < samples.rows();) {
    const std::int32_t experiment = samples.experiment[row];
    const Eigen::Index tools = tools_at(samples, row);
    std::vector<PlayedTool> played;
    std::vector<Vec3> outside, down, to(static_cast<std::size_t>(tools));
    for (Eigen::Index i = 0; i < tools; ++i) {
      const std::int32_t place = samples.point[row + i];
      const Vec3 at = samples.point_position.row(place), normal = samples.point_normal.row(place);
      const double depth = Vec3(samples.deflection.row(row + i)).dot(normal);
      played.push_back(played_as ? played_as(row + i) : PlayedTool());
      outside.push_back(at + (std::min(0.0, depth) - kApproachRatio * depth_m) * normal);
      down.push_back(at + depth * normal);
    }
    if (!body_.empty()) runtime::start_body(view_, body_.data());  // as before any touch
    ToolsWalk walk(view_, met_, std::move(played), std::move(outside));
    if (samples.kind[row] == ExperimentKind::drag) walk.go(down, kNan);
    // A scan has its recording's clock: a quarter of a second brings the tool to a pass.
    const bool is_scan = samples.kind[row] == ExperimentKind::scan;
    for (double before_s = is_scan ? samples.time_of(row) - 0.25 : 0;
         row < samples.rows() && samples.experiment[row] == experiment;
         before_s = samples.time_of(row), row += tools) {
      for (Eigen::Index i = 0; i < tools; ++i)
        to[i] =
            samples.point_position.row(samples.point[row + i]) + samples.deflection.row(row + i);
      walk.go(to, samples.time_of(row) - before_s);
      for (Eigen::Index i = 0; i < tools; ++i) {
        const auto tool = static_cast<std::size_t>(i);
        out.force_N.row(row + i) = walk.force_N(tool);
        out.torque_Nm.row(row + i) = walk.torque_Nm(tool);
        out.is_sliding[row + i] = walk.is_sliding(tool);
        out.flags[row + i] = walk.flags(tool);
        if (on_row) on_row(row + i, walk.tool(tool));
      }
    }
    out.ticks += walk.ticks();
  }
  return out;
}

runtime::AssetView coupled_by(const runtime::AssetView& asset,
                              const runtime::CouplingView& coupling) {
  runtime::AssetView out = asset;
  out.coupling = coupling.is_any() ? &coupling : nullptr;
  return out;
}

Eigen::VectorXd row_scales_N(const Samples& samples) {
  std::map<std::pair<std::int32_t, int>, double> largest_N;  // of an experiment's tool
  const auto largest_of = [&](Eigen::Index row) -> double& {
    return largest_N[{samples.experiment[row], samples.tool_of(row)}];
  };
  const Eigen::VectorXd force_N = samples.force.rowwise().norm();
  for (Eigen::Index row = 0; row < samples.rows(); ++row)
    if (samples.status[row] == RowStatus::good)
      largest_of(row) = std::max(largest_of(row), force_N[row]);
  Eigen::VectorXd out = Eigen::VectorXd::Zero(samples.rows());
  for (Eigen::Index row = 0; row < samples.rows(); ++row)
    if (samples.status[row] == RowStatus::good)
      out[row] = std::max(force_N[row], relative_floor(largest_of(row)));
  return out;
}

}  // namespace palpate
