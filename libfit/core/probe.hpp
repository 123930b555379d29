#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libfit/core/geometry.hpp"
#include "libfit/core/units.hpp"
#include "libfit/runtime/law/indenter.hpp"

namespace palpate {

/// A ball of 5 mm and Coulomb friction of 0.3, where nothing else is said.
inline constexpr double kDefaultBallRadius_m = 5e-3;
inline constexpr double kDefaultFriction = 0.3;

/// The end of a tool that is round about its press, as the engine plays it.
using runtime::Indenter;

/// The rigid tool of an experiment. It travels with the data: samples, curves, model and asset
/// carry it. values: by key of the shape's parameters (libfem/probes), SI; keys left out take their
/// defaults. mesh: closed, outward [m], for the shape `mesh` alone. For shapes that are not round
/// about their axis: orientation, in the shape's own axes, is the direction that points into the
/// body (default: own z, the mesh's own -z). Own z, or own x where z points along the press, leans
/// to the first drag direction: the coordinate axis least along the normal.
struct ProbeSpec {
  std::string shape = "sphere";
  std::map<std::string, std::vector<double>, std::less<>> values;
  Surface mesh;
  std::optional<Vec3> orientation;
  double friction = 0;  ///< Coulomb coefficient of the interface, 0 for none
};

inline ProbeSpec sphere_spec(double radius_m, double friction = 0) {
  ProbeSpec spec;
  spec.values["radius"] = {radius_m};
  spec.friction = friction;
  return spec;
}

/// Radius of a ball; 0 for other shapes, which the engine plays as a point, and for no probe.
inline double ball_radius_m(const std::optional<ProbeSpec>& probe) {
  if (!probe || probe->shape != "sphere") return 0;
  const auto radius = probe->values.find("radius");
  return radius == probe->values.end() || radius->second.empty() ? kDefaultBallRadius_m
                                                                 : radius->second.front();
}

/// Dimension of a key of ProbeSpec::values: keys that end in "angle" are angles, others lengths.
constexpr Dimension probe_dimension(std::string_view key) {
  return key.ends_with("angle") ? Dimension::angle : Dimension::length;
}

/// Lean of a tool: sin(tilt) times the direction that its shaft leans to, in tilt_frame(). Zero
/// is upright, its axis along the normal; shorter than 1.
using Lean = Eigen::Vector2d;

inline Lean lean_of(double tilt_rad, double direction_rad) {
  return std::sin(tilt_rad) * Lean(std::cos(direction_rad), std::sin(direction_rad));
}

/// Columns: the two tangents that leans are given in (M58b), and the inward unit normal u. The
/// tangents are where the least turn from z to the outward normal takes x and y; they change
/// smoothly over a body but where that normal is -z.
inline Mat3 tilt_frame(const Vec3& inward) {
  const Vec3 outward = -inward, middle = outward + Vec3::UnitZ();
  Vec3 first = Vec3::UnitX();
  // Below it a place has the pole's frame.
  if (middle.z() > 1e-9) first -= middle * (outward.x() / middle.z());
  Mat3 frame;
  frame << first, outward.cross(first), inward;
  return frame;
}

/// The turn, in the body's axes, of a tool that stands upright to one that leans (M58c).
inline Mat3 tilt_turn(const Vec3& inward, const Lean& lean) {
  const double sine = lean.norm();
  if (!(sine > 0)) return Mat3::Identity();
  const Vec3 towards = tilt_frame(inward).leftCols<2>() * (lean / sine);
  return Eigen::AngleAxisd(std::asin(std::min(sine, 1.0)), Vec3((-inward).cross(towards)))
      .toRotationMatrix();
}

/// Pose of a tool: its own axes in the body's, as columns, and in them its reference point,
/// which a path moves [m].
struct Stance {
  Mat3 axes = Mat3::Identity();
  Vec3 touch_m = Vec3::Zero();
};

}  // namespace palpate
