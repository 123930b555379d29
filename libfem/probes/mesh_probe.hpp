#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "libfem/probes/mesh_field.hpp"
#include "libfem/probes/probe_frame.hpp"

namespace palpate::fem {

/// A closed triangle mesh, smoothed as MeshField says. The reference point is the mesh's farthest
/// along the direction into the body (the middle of a face or edge that lies across it), moved
/// along the axis onto the smoothed surface.
struct MeshShape {
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
      const Vec3 a = surface.vertices.row(t(f, 0)), b = surface.vertices.row(t(f, 1)),
                 c = surface.vertices.row(t(f, 2));
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
