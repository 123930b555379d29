#pragma once

#include <vector>

#include "libfit/core/body.hpp"
#include "libfit/refine/edge_paths.hpp"

namespace palpate {

/// Cosine of 75 degrees, between normals that go together: passes the chords of a coarse
/// triangulation and refuses the other side of a thin part.
inline constexpr double kMinCosine = 0.25881904510252074;

/// Whether a normal, of any length, is within acos(cosine) of a unit vector.
inline bool faces_alike(const Vec3& normal, const Vec3& unit, double cosine = kMinCosine) {
  return normal.dot(unit) > cosine * normal.norm();
}

/// Blend of three rows.
template <class Corners>
Vec3 blended(const Points& rows, const Corners& corners, const Vec3& weight) {
  Vec3 out = Vec3::Zero();
  for (int k = 0; k < 3; ++k) out += weight[k] * rows.row(corners[k]).transpose();
  return out;
}

/// Where each test point sits on the surface: the corners of the nearest triangle whose
/// interpolated normal is within acos(min_cosine) of the point's. position, inward: P x 3.
/// outward_normal: #V x 3 of the surface. No seed for a point farther than max_m from the surface.
std::vector<EdgePathSeeds> place_on_surface(const Points& position, const Points& inward,
                                            const Surface& surface, const Points& outward_normal,
                                            double min_cosine, double max_m);

/// Test-point triangles dual to the cells of nearest test points: a fine triangle whose vertices
/// belong to three points joins them. cell: #V, the nearest point along the surface. Same
/// orientation as the surface; a triangle facing against the normals of its points (it closes the
/// surface behind the outermost ones) is dropped. Each once, ascending.
Triangles triangulate_over(const Surface& surface, const std::vector<std::int32_t>& cell,
                           const Points& position, const Points& inward);

/// The triangles of the test points, over rows of `position` instead: points are paired by position
/// within 1e-6 of `size_m` (the body's diagonal). position P x 3 [m].
/// Empty when the pairing is not one to one: then the points are not the body's own.
Triangles match_triangles(const Points& position, const TestPoints& points, double size_m);

}  // namespace palpate
