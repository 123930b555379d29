#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "libfem/probes/probes.hpp"
#include "libfit/core/closest_point.hpp"
#include "libfit/core/geometry.hpp"

namespace palpate::fem {

/// Signed distance to a closed triangle mesh, exact and smoothed.
/// The exact distance has kinks at every edge and no curvature on facets, where Newton's method
/// would chatter. Contact uses its smooth image: the exact distance sampled on a grid of
/// spacing `smoothing`, in between a cubic B-spline whose coefficients c = f - 1/6 sum of second
/// differences reproduce cubics, so that smooth parts stay where they are to fourth order and edges
/// are rounded over about one spacing. It has two continuous derivatives, and gradient and hessian
/// are its own; its gradient is shorter than 1 where an edge has been rounded. Outside the grid,
/// more than three spacings off the mesh's box, the exact distance answers. Const members are
/// thread-safe and do not allocate. Sources: Baerentzen and Aanaes 2005 (doi:10.1109/TVCG.2005.49)
/// for the sign; de Boor and Fix 1973 for the coefficients.
class MeshField {
 public:
  /// surface [m]: closed, outward. smoothing_m: NaN for 1/64 of its largest extent. Throws Error at
  /// `where` when an edge has not two triangles that agree, a vertex joins several sheets, a
  /// triangle has no area, it encloses no positive volume, or smoothing is below 1/160 or above 1/8
  /// of the extent.
  MeshField(Surface surface, double smoothing_m, const std::string& where);

  SignedDistance exact(const Vec3& x) const {
    return nearest(x, std::numeric_limits<double>::infinity());
  }
  SignedDistance smooth(const Vec3& x) const;

  const Surface& surface() const { return surface_; }
  double smoothing_m() const { return spacing_; }
  double extent_m() const { return extent_; }

  /// The section across `inward` (unit) that lies depth_m behind `tip`, by its area [m^2], and
  /// across the axis, from `tip`, the ends [m] of the line from which none of its border is farther
  /// than width_m; a section that is not slender has a point for a line.
  struct CrossSection {
    double area_m2 = 0, width_m = 0;
    Vec3 from = Vec3::Zero(), to = Vec3::Zero();
  };
  CrossSection section(const Vec3& tip, const Vec3& inward, double depth_m) const;

 private:
  /// within_m: no less than the distance there, to search less.
  SignedDistance nearest(const Vec3& x, double within_m) const;
  Vec3 corner(std::int32_t triangle, int k) const {
    return surface_.vertices.row(surface_.triangles(triangle, k));
  }
  void average_normals();
  void sample();
  std::size_t place(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * count_[1] + j) * count_[0] + i;
  }

  Surface surface_;
  double extent_ = 0, spacing_ = 0;
  BoxTree boxes_;
  Points face_normal_, vertex_normal_;  // unit; vertices: weighted by angle
  Points edge_normal_;                  // 3 #F: row 3 f + k, across the edge (k, k+1), not unit
  Vec3 origin_ = Vec3::Zero();          // of the grid
  std::array<int, 3> count_{};
  std::vector<double> coefficient_;
};

}  // namespace palpate::fem
