#pragma once

#include <optional>
#include <vector>

#include "libfit/core/geometry.hpp"

namespace palpate::recordings {

/// Carries points of the rig's frame into the body's: rotation * x + translation_m.
struct RigidMotion {
  Mat3 rotation = Mat3::Identity();
  Vec3 translation_m = Vec3::Zero();

  Vec3 operator()(const Vec3& x) const { return rotation * x + translation_m; }
};

/// A motion with what it leaves: distances after it, root mean square and largest.
struct Registration {
  RigidMotion motion;
  double rms_m = 0, largest_m = 0;
  int iterations = 0;  ///< of ICP; 0 for landmarks alone
};

/// The motion that brings `from` nearest to `to` in the least squares sense, without mirroring.
/// Throws Error when there are fewer than 3 pairs or they lie on one line.
/// Source: Kabsch (1976), Umeyama (1991).
Registration register_landmarks(const Points& from, const Points& to);

/// Refines a motion so that `points` come to lie on the surface: iterative closest points with
/// distances along the surface's normals (Chen and Medioni 1992), up to 50 steps or until it moves
/// by less than 1e-9 of the surface. Points that lie farther than 3 robust deviations are left out
/// of a step. Throws Error with fewer than 6 points.
Registration register_to_surface(const Points& points, const Surface& surface,
                                 const RigidMotion& start);

/// Where a point belongs on a surface.
struct SurfacePlace {
  Vec3 position_m;
  Vec3 inward;  ///< unit, from the vertex normals
  double distance_m = 0;
};

/// Nearest surface points. Nothing where there is no triangle with an area.
std::vector<std::optional<SurfacePlace>> project(const Points& points, const Surface& surface);

}  // namespace palpate::recordings
