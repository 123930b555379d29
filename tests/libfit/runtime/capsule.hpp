#pragma once

#include <Eigen/Geometry>

#include "libfit/runtime/tool/tool.hpp"
#include "tests/libfit/runtime/hands.hpp"

// A rigid tool of several balls on a body of rings.
namespace palpate::test {

using runtime::ToolInput;
using runtime::ToolOutput;

inline constexpr double kRadius_m = 0.004, kHalf_m = 0.008;

inline Model rings_model(bool is_round, double friction, double slope = 0) {
  Model model = testing_hands::rings_body(is_round, friction, slope);
  model.probe = sphere_spec(kRadius_m, friction);
  model.curves.coupling.length_m = 0.003;
  for (int k = 0; k < 3; ++k) {
    model.curves.coupling.isotropic_m_N[k] = 0.001;
    model.curves.coupling.tangential_m_N[k] = 0.0005;
  }
  return model;
}

inline runtime::Pose to_pose(const Eigen::Isometry3d& pose) {
  const Eigen::Quaterniond turn(pose.linear());
  runtime::Pose out;
  Vec3::Map(out.position_m) = pose.translation();
  const double q[4] = {turn.w(), turn.x(), turn.y(), turn.z()};
  std::copy(q, q + 4, out.orientation);
  return out;
}

// A lying capsule: four balls along own x.
struct Capsule {
  Loaded loaded;
  runtime::Tool tool;
  ToolOutput out;

  explicit Capsule(const Model& model, int balls = 4) : loaded(load(model)) {
    tool.shape.balls = balls;
    for (int i = 0; i < balls; ++i) {
      tool.shape.ball[i].radius_m = kRadius_m;
      tool.shape.ball[i].centre_m[0] = balls == 1 ? 0 : kHalf_m * (2.0 * i / (balls - 1) - 1);
    }
  }
  runtime::Status tick(const Eigen::Isometry3d& pose, double dt_s = 1e-3) {
    ToolInput in;
    in.pose = to_pose(pose);
    in.dt_s = dt_s;
    runtime::Tool* const only = &tool;
    runtime::Status status;
    touch_tools(loaded.asset, &only, &in, &out, &status, 1);
    return status;
  }
  Vec3 force() const { return -Vec3::Map(out.force_on_tool_N); }
  Vec3 torque() const { return -Vec3::Map(out.torque_on_tool_Nm); }

  /// What it stores after another tick, which is undone.
  double stored_after(const Eigen::Isometry3d& pose) {
    const runtime::Tool before = tool;
    const ToolOutput said = out;
    tick(pose);
    const double stored_J = out.stored_J;
    tool = before;
    out = said;
    return stored_J;
  }
};

inline Eigen::Isometry3d pose_at(const Vec3& place, const Vec3& turn_rad) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  const double angle = turn_rad.norm();
  if (angle > 0) pose.rotate(Eigen::AngleAxisd(angle, Vec3(turn_rad / angle)));
  pose.pretranslate(place);
  return pose;
}

}  // namespace palpate::test
