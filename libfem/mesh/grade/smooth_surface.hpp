#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "libfit/core/closest_point.hpp"
#include "libfit/core/geometry.hpp"

namespace palpate::fem {

/// Point of a smooth surface nearest to a query.
struct SurfaceHit {
  std::int32_t triangle = -1;
  Vec3 weights = Vec3::Zero();   ///< barycentric, sum 1
  Vec3 on_facet = Vec3::Zero();  ///< nearest point of the flat triangle [m]
  Vec3 position = Vec3::Zero();  ///< the same weights on the smooth surface [m]
  Vec3 normal = Vec3::Zero();    ///< outward unit, interpolated from the corners
  double distance_m = 0;         ///< from the query point to on_facet
};

/// A smooth surface through the vertices of a triangulated one, its creases kept.
/// Each corner of a triangle has the angle-weighted normal of the fan of triangles that reaches it
/// without crossing a crease: an edge whose triangles meet at more than 40 degrees, or that
/// has not exactly two triangles. Inside a triangle, with barycentric weights w and p = sum w_i
/// p_i,
///
///     x(w) = p - 1/2 sum_i w_i ((p - p_i) . n_i) n_i        (Phong tessellation, factor 1/2)
///
/// Boubekeur and Alexa 2008 (doi:10.1145/1409060.1409085) take 3/4 for the looks. 1/2 is the value
/// that reproduces any quadric to second order: over z = x.Hx/2, sum w_i (p - p_i).n_i is twice the
/// height of the facet above it. Edge midpoints agree with those of PN triangles. A box with sharp
/// edges is reproduced exactly. On a crease the two sides may disagree by the facets' sagitta
/// there. Const members are thread-safe; results depend on the surface alone.
class SmoothSurface {
 public:
  static constexpr double kCreaseAngle_rad = 40 * 3.14159265358979323846 / 180;

  /// Throws Error when there is no triangle with area.
  explicit SmoothSurface(Surface surface);

  /// Nearest point over all triangles; of two as near, that of the lower triangle index.
  /// point [m]. Source: Ericson, Real-Time Collision Detection (2005), 5.1.5.
  SurfaceHit closest(const Vec3& point) const;

  /// Nearest point over triangles whose outward normal is within the angle of cosine `min_cosine`
  /// to `direction` (any length), so that a thin sheet's other side is never hit. Empty without
  /// one.
  std::optional<SurfaceHit> closest(const Vec3& point, const Vec3& direction,
                                    double min_cosine) const;

  /// Nearest point on a crease (a straight polyline) within `within_m`; empty without one.
  std::optional<Vec3> closest_crease(const Vec3& point, double within_m) const;

  /// The smooth surface at barycentric weights of a triangle [m].
  Vec3 lifted(std::int32_t triangle, const Vec3& weights) const;

  /// Outward unit normal at barycentric weights of a triangle: corner normals interpolated.
  Vec3 normal(std::int32_t triangle, const Vec3& weights) const;

  /// du/dc [1/m] of the inward unit normal along the surface at a hit (or the point closest to
  /// `point`): symmetric, its null space holds the hit's normal; -1/R on the tangents of a sphere
  /// of radius R. Least squares of a cubic height function over the patch within `radius_m` [m]
  /// (the size of what will touch it), weighted by area and falling to zero at the rim; the patch
  /// stops at creases. A sphere is overestimated by about 0.15 (radius/R)^2. Source: Cazals and
  /// Pouget 2005 (doi:10.1016/j.cagd.2004.09.004).
  Mat3 normal_gradient(const SurfaceHit& hit, double radius_m) const;

  const Surface& surface() const { return surface_; }

 private:
  Vec3 corner(std::int32_t triangle, int k) const {
    return surface_.vertices.row(surface_.triangles(triangle, k));
  }
  template <class Accept>
  std::optional<SurfaceHit> closest_where(const Vec3& point, Accept&& accept) const;
  DisjointSets find_neighbours();  // returns the fans of corners between creases
  void average_corner_normals(DisjointSets fans);
  std::vector<std::int32_t> patch_around(const SurfaceHit& centre, double radius_m) const;

  Surface surface_;
  Points facet_normal_;         // #F x 3 unit, zero without area
  Points corner_normal_;        // 3#F x 3 unit, row 3f + k
  Triangles smooth_neighbour_;  // #F x 3: triangle across edge (k, k+1), -1 at a crease
  std::vector<std::array<std::int32_t, 2>> crease_;
  BoxTree triangle_boxes_, crease_boxes_;
};

/// When a triangle is too large [m]. longest_m: an edge is longer. sagitta_m: the smooth surface is
/// farther from the middle of an edge, and the longest edge is longer than shortest_m.
struct DivisionLimits {
  double longest_m = std::numeric_limits<double>::infinity();
  double sagitta_m = std::numeric_limits<double>::infinity();
  double shortest_m = 0;
};

/// True where a triangle with these corners [m], a part of triangle `of` of the surface, is to
/// be divided where it is too large.
using IsDivided = std::function<bool(std::int32_t of, const Vec3& a, const Vec3& b, const Vec3& c)>;

/// The surface with its triangles divided until none that is_divided is too large. New vertices lie
/// on the smooth surface, on a crease in the middle of what its two sides say; what is flat keeps
/// its shape but for rounding. A surface that is closed and manifold stays so: an edge is cut for
/// both its triangles. Vertices keep their numbers, new ones come after them. In the plane angles
/// stay above about half of the smallest there is (the longest edge is cut, and those of neighbours
/// before it). Source: Rivara 1984, doi:10.1002/nme.1620200412.
Surface divided(const SmoothSurface& surface, const IsDivided& is_divided,
                const DivisionLimits& limits);

/// The same within radius_m [m] of `centre`, by the length of edges. Throws Error as SmoothSurface
/// does.
Surface divided_near(const Surface& surface, const Vec3& centre, double radius_m, double longest_m);

}  // namespace palpate::fem
