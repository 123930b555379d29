#include "libfit/fit/compound.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "libfit/fit/walk.hpp"

namespace palpate {
namespace {

class CompoundWalk {
 public:
  CompoundWalk(const runtime::AssetView& asset, const runtime::ToolShape& shape,
               const Stance& stance, const Vec3& place)
      : asset_(asset), stance_(stance), at_(place) {
    if (asset.coupling != nullptr) tools_.emplace_back().shape = shape;
    for (int i = 0; asset.coupling == nullptr && i < shape.balls; ++i)
      tools_.emplace_back().shape.ball[0] = shape.ball[i];
    const Eigen::Quaterniond turn(stance.axes);
    double* q = in_.pose.orientation;
    q[0] = turn.w(), q[1] = turn.x(), q[2] = turn.y(), q[3] = turn.z();
    in_.dt_s = runtime::kMaxTimeStep_s;
    tick(place);
  }

  void go(const Vec3& to) {
    const Vec3 from = at_;
    const int steps = ticks_over((to - from).norm());
    for (int k = 1; k <= steps; ++k) tick(from + (to - from) * (double(k) / steps));
  }
  Vec3 force_N() const { return force_N_; }
  // About the reference point.
  Vec3 torque_Nm() const {
    const Vec3 to_origin = -(stance_.axes * stance_.touch_m);
    return torque_Nm_ + to_origin.cross(force_N_);
  }
  std::size_t ticks() const { return ticks_; }

 private:
  void tick(const Vec3& place) {
    at_ = place;
    Eigen::Map<Vec3>(in_.pose.position_m) = place - stance_.axes * stance_.touch_m;
    force_N_.setZero();
    torque_Nm_.setZero();
    for (runtime::Tool& tool : tools_) {
      runtime::ToolOutput out;
      touch_tool(asset_, tool, in_, out);
      force_N_ -= Eigen::Map<const Vec3>(out.force_on_tool_N);
      torque_Nm_ -= Eigen::Map<const Vec3>(out.torque_on_tool_Nm);
    }
    ++ticks_;
  }

  const runtime::AssetView& asset_;
  const Stance& stance_;
  std::vector<runtime::Tool> tools_;  // the whole, or each ball where none feels another
  runtime::ToolInput in_;
  Vec3 at_;
  Vec3 force_N_ = Vec3::Zero(), torque_Nm_ = Vec3::Zero();  // on the body, about the tool's origin
  std::size_t ticks_ = 0;
};

// Of the balls about their middle, and of what the largest one's own surface adds.
double lever_m(const runtime::ToolShape& shape) {
  const auto centre = [&](int i) { return Eigen::Map<const Vec3>(shape.ball[i].centre_m); };
  Vec3 middle = Vec3::Zero();
  for (int i = 0; i < shape.balls; ++i) middle += centre(i) / shape.balls;
  double squares = 0, radius_m = 0;
  for (int i = 0; i < shape.balls; ++i) {
    squares += (centre(i) - middle).squaredNorm() / shape.balls;
    radius_m = std::max(radius_m, shape.ball[i].radius_m);
  }
  return radius_m + std::sqrt(squares);
}

}  // namespace

CompoundForces replay_compound(const runtime::AssetView& asset,
                               const runtime::CouplingView& coupling, const CompoundPaths& tool,
                               const Samples& samples, double depth_m) {
  CompoundForces out{Points::Zero(samples.rows(), 3), Points::Zero(samples.rows(), 3)};
  runtime::AssetView view = asset;
  view.coupling = coupling.is_any() ? &coupling : nullptr;
  WalkedBody body(view);
  for (Eigen::Index row = 0; row < samples.rows();) {
    const std::int32_t experiment = samples.experiment[static_cast<std::size_t>(row)];
    const auto path = static_cast<std::size_t>(experiment);
    const Vec3 point = samples.point_position.row(tool.paths[path].point),
               normal = samples.point_normal.row(tool.paths[path].point),
               first = samples.deflection.row(row);
    const double outside_m = std::min(0.0, first.dot(normal)) - kApproachRatio * depth_m;
    CompoundWalk walk(body.fresh(), tool.shape[path], tool.stance[path],
                      point + outside_m * normal);
    for (; row < samples.rows() && samples.experiment[static_cast<std::size_t>(row)] == experiment;
         ++row) {
      walk.go(point + samples.deflection.row(row).transpose());
      out.force_N.row(row) = walk.force_N();
      out.torque_Nm.row(row) = walk.torque_Nm();
    }
    out.ticks += walk.ticks();
  }
  return out;
}

Eigen::VectorXd compound_residual(const CompoundPaths& tool, const Samples& samples,
                                  const CompoundForces& answered) {
  Eigen::VectorXd largest_N = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(tool.paths.size()));
  const auto is_good = [&](Eigen::Index row) {
    return samples.status[static_cast<std::size_t>(row)] == RowStatus::good;
  };
  const auto path_of = [&](Eigen::Index row) {
    return samples.experiment[static_cast<std::size_t>(row)];
  };
  for (Eigen::Index row = 0; row < samples.rows(); ++row)
    if (is_good(row))
      largest_N[path_of(row)] = std::max(largest_N[path_of(row)], samples.force.row(row).norm());
  Eigen::VectorXd out = Eigen::VectorXd::Zero(6 * samples.rows());
  for (Eigen::Index row = 0; row < samples.rows(); ++row) {
    const double scale =
        std::max(samples.force.row(row).norm(), kLightRow * largest_N[path_of(row)]);
    if (!is_good(row) || !(scale > 0)) continue;
    out.segment<3>(6 * row) = (answered.force_N.row(row) - samples.force.row(row)) / scale;
    const double lever = lever_m(tool.shape[static_cast<std::size_t>(path_of(row))]);
    out.segment<3>(6 * row + 3) =
        (answered.torque_Nm.row(row) - samples.torque.row(row)) / (scale * lever);
  }
  return out;
}

}  // namespace palpate
