#pragma once

#include <memory>
#include <optional>

#include "libfit/core/surface.hpp"

namespace palpate {

/// The point of a surface nearest to a query.
struct SurfaceHit {
  Vec3 point = Vec3::Zero();  ///< [m]
  std::int32_t triangle = -1;
  Vec3 barycentric = Vec3::Zero();  ///< of `point` in the triangle, sum 1
  double distance_m = 0;
};

/// Nearest-point and ray queries on a triangulated surface, built once, asked often.
/// Holds a copy of what it needs. Answers do not depend on earlier queries; safe to share between
/// threads. Triangles without area are left out. Throws Error when none is left.
/// Source: Alliez, Tayeb, Wormser, "3D Fast Intersection and Distance Computation", CGAL 5.5.
class SurfaceTree {
 public:
  explicit SurfaceTree(const Surface& surface);
  ~SurfaceTree();
  SurfaceTree(SurfaceTree&&) noexcept;
  SurfaceTree& operator=(SurfaceTree&&) noexcept;

  SurfaceHit closest(const Vec3& query) const;

  /// Distance [m] along `direction` (unit) from `origin` to the first triangle met beyond
  /// `skip_m`; nothing when the ray leaves without meeting one.
  std::optional<double> ray_distance_m(const Vec3& origin, const Vec3& direction,
                                       double skip_m) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

/// Largest distance [m] between two surfaces, both ways, sampled at vertices, edge midpoints and
/// triangle centres of each: a lower bound of their Hausdorff distance, close to it when the
/// sampled features are no larger than the triangles.
double deviation_m(const Surface& a, const SurfaceTree& tree_of_a, const Surface& b);

}  // namespace palpate
