#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "libfem/mesh/topology.hpp"
#include "libfem/probes/probes.hpp"
#include "libfem/probes/shapes.hpp"
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

/// A closed triangle mesh, smoothed as MeshField says. The reference point is the mesh's farthest
/// along the direction into the body (the middle of a face or edge that lies across it), moved
/// along the axis onto the smoothed surface.
struct MeshShape : ProbeShape<MeshShape> {
  static constexpr ProbeParameter kParameters[] = {
      {"smoothing", "over which edges are rounded; 1/64 of the largest extent when left out",
       "0.2 mm", Dimension::length, false}};

  static std::string complete(ProbeGeometry& probe) {
    const MeshField& field = *probe.mesh;
    probe.number[0] = field.smoothing_m();
    const Vec3 inward = probe.turn.row(2),
               tip = foremost(field.surface(), inward, field.extent_m());
    // Bisection between a place outside and one inside.
    double inside = 4 * field.smoothing_m(), outside = -4 * field.smoothing_m();
    if (!(field.smooth(tip - inside * inward).distance_m < 0))
      return "the mesh's tip is thinner than smoothing; give a smaller smoothing";
    for (int halving = 0; halving < 60; ++halving) {
      const double middle = (inside + outside) / 2;
      (field.smooth(tip - middle * inward).distance_m < 0 ? inside : outside) = middle;
    }
    probe.touch = tip - outside * inward;
    return {};
  }

  static SignedDistance signed_distance(const ProbeGeometry& probe, const Vec3& axis,
                                        const Vec3& offset) {
    return in_own_axes(probe, axis, offset, [&](const Vec3& x) { return probe.mesh->smooth(x); });
  }

  /// Grown by a spacing, which smoothing never adds.
  static BoundingBall bounding_ball(const ProbeGeometry& probe) {
    const Points& vertices = probe.mesh->surface().vertices;
    const Vec3 inward = probe.turn.row(2);
    const Vec3 middle =
        (vertices.colwise().minCoeff() + vertices.colwise().maxCoeff()).transpose() / 2;
    const double along = (middle - probe.touch).dot(inward);
    const Vec3 centre = probe.touch + along * inward;
    return {along, (vertices.rowwise() - centre.transpose()).rowwise().norm().maxCoeff() +
                       probe.mesh->smoothing_m()};
  }

  /// sqrt(A / 2 pi) with the section's area A at that depth: exact for a ball's paraboloid.
  static double contact_radius_m(const ProbeGeometry& probe, double depth_m) {
    const double area = section(probe, depth_m).area_m2;
    return std::max(std::sqrt(area / (2 * std::numbers::pi)), probe.mesh->smoothing_m());
  }
  static double contact_reach_m(const ProbeGeometry& probe, double depth_m) {
    return std::max(section(probe, depth_m).width_m, contact_radius_m(probe, depth_m));
  }
  static ContactLine contact_line_m(const ProbeGeometry& probe, double depth_m) {
    const MeshField::CrossSection own = section(probe, depth_m);
    return {probe.turn * own.from, probe.turn * own.to};
  }
  static double tip_radius_m(const ProbeGeometry& probe) {
    const double depth = 4 * probe.mesh->smoothing_m(), radius = contact_radius_m(probe, depth);
    return std::min(radius * radius / depth, half_width_m(probe));
  }
  static double half_width_m(const ProbeGeometry& probe) {
    const Vec3 inward = probe.turn.row(2);
    double farthest = 0;
    const Points& vertices = probe.mesh->surface().vertices;
    for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
      const Vec3 from = vertices.row(v).transpose() - probe.touch;
      farthest = std::max(farthest, (from - from.dot(inward) * inward).norm());
    }
    return farthest;
  }

 private:
  /// Section behind the tip, no deeper than half the mesh, where a tool may narrow again.
  static MeshField::CrossSection section(const ProbeGeometry& probe, double depth_m) {
    return probe.mesh->section(probe.touch, probe.turn.row(2),
                               std::min(depth_m, probe.mesh->extent_m() / 2));
  }

  static Vec3 foremost(const Surface& surface, const Vec3& inward, double extent_m) {
    const double farthest = (surface.vertices * inward).maxCoeff(), within = 1e-6 * extent_m;
    const auto is_there = [&](Eigen::Index v) {
      return surface.vertices.row(v).dot(inward) > farthest - within;
    };
    Vec3 sum = Vec3::Zero();
    double weight = 0;
    for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f) {
      const auto& t = surface.triangles;
      if (!(is_there(t(f, 0)) && is_there(t(f, 1)) && is_there(t(f, 2)))) continue;
      const auto [a, b, c] = corners_of(surface, f);
      const double area = (b - a).cross(c - a).norm();
      sum += area * (a + b + c) / 3;
      weight += area;
    }
    if (weight > 0) return sum / weight;
    for (Eigen::Index v = 0; v < surface.vertices.rows(); ++v)
      if (is_there(v)) {
        sum += surface.vertices.row(v).transpose();
        ++weight;
      }
    return sum / weight;
  }
};

}  // namespace palpate::fem
