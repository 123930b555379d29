#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "libfem/probes/probe_frame.hpp"
#include "libfit/core/linear_algebra.hpp"

namespace palpate::fem {

/// Ellipsoid with semi-axes along own x, y, z. The reference point is where its tangent plane is
/// across the direction into the body: the pole of own z unless it is tilted. The nearest surface
/// point is y_i = e_i^2 x_i / (t + e_i^2), t the largest root of sum (e_i x_i / (t + e_i^2))^2 = 1,
/// by Newton's method from below, where the sum is convex and falls: it never overshoots. Source:
/// Eberly 2013, Distance from a Point to an Ellipse, an Ellipsoid. Derivatives are those of the
/// signed distance s of a smooth surface: with S the derivative of the unit normal n along the
/// surface at y, the gradient is n(y) and the hessian (1 + s S)^-1 S.
struct EllipsoidShape {
  static constexpr ProbeParameter kParameters[] = {
      {"semi_axes", "along the heading, across it and along the press",
       "[\"5 mm\", \"3 mm\", \"8 mm\"]", Dimension::length, 3}};
  static constexpr double kMaxSlender = 50;

  static Vec3 semi_axes_m(const ProbeGeometry& probe) {
    return {probe.number[0], probe.number[1], probe.number[2]};
  }

  static std::string complete(ProbeGeometry& probe) {
    const Vec3 e = semi_axes_m(probe), inward = probe.turn.row(2);
    if (e.maxCoeff() > kMaxSlender * e.minCoeff())
      return "semi_axes may differ by a factor of 50 at most";
    probe.touch = e.cwiseAbs2().cwiseProduct(inward) / e.cwiseProduct(inward).norm();
    return {};
  }

  /// The nearest point of the surface to x, own axes.
  static Vec3 nearest(const Vec3& e, const Vec3& x) {
    Eigen::Index least = 0;
    e.minCoeff(&least);
    const Vec3 square = e.cwiseAbs2(), above = (square.array() - square[least]).matrix();
    const Vec3 scaled = e.cwiseProduct(x.cwiseAbs());
    // w = t + e_min^2 >= 0; the sum is 1 to 3 at the start, so few steps follow.
    double w = std::max(0.0, (scaled - above).maxCoeff());
    const auto sum_at = [&](double at, double& slope) {
      double sum = 0;
      slope = 0;
      for (int i = 0; i < 3; ++i) {
        if (scaled[i] == 0) continue;
        const double ratio = scaled[i] / (at + above[i]);
        sum += ratio * ratio;
        slope -= 2 * ratio * ratio / (at + above[i]);
      }
      return sum;
    };
    double slope = 0;
    for (int step = 0; step < 60; ++step) {
      const double over = sum_at(w, slope) - 1;
      if (!(over > 0)) break;
      const double next = w - over / slope;
      if (!(next > w)) break;
      w = next;
    }
    Vec3 y;
    double filled = 0;
    for (int i = 0; i < 3; ++i) {
      const double below = w + above[i];
      y[i] = below > 0 ? square[i] * x[i] / below : 0;
      if (i != least) filled += y[i] * y[i] / square[i];
    }
    // On the medial axis, inside the middle plane of the shortest axis, that axis takes what is
    // left.
    if (x[least] == 0) y[least] = e[least] * std::sqrt(std::max(0.0, 1 - filled));
    return y;
  }

  /// Derivative of the unit normal along the surface at y (own axes).
  static Mat3 normal_derivative(const Vec3& e, const Vec3& y, Vec3& normal) {
    const Vec3 m = e.cwiseAbs2().cwiseInverse();
    const Vec3 up = m.cwiseProduct(y);
    const double size = up.norm();
    normal = up / size;
    const Mat3 plane = Mat3::Identity() - normal * normal.transpose();
    return plane * m.asDiagonal() * plane / size;
  }

  static SignedDistance signed_distance(const ProbeGeometry& probe, const Vec3& axis,
                                        const Vec3& offset) {
    const Vec3 e = semi_axes_m(probe);
    return in_own_axes(probe, axis, offset, [&](const Vec3& x) {
      SignedDistance out;
      const Vec3 y = nearest(e, x);
      const Mat3 curvature = normal_derivative(e, y, out.gradient);
      out.distance_m = out.gradient.dot(x - y);
      const Mat3 spread = Mat3::Identity() + out.distance_m * curvature;
      constexpr double kFocal = 1e-9;  // at a centre of curvature the hessian has no value
      const double det = spread.determinant();
      if (det > kFocal) out.hessian = spread.inverse() * curvature;
      return out;
    });
  }

  static BoundingBall bounding_ball(const ProbeGeometry& probe) {
    return ball_about_origin(probe, semi_axes_m(probe).maxCoeff());
  }

  /// Half-widths of a contact at a depth along the two principal directions at the reference point,
  /// the smaller first: sqrt(R_i d) as for a ball, no wider than the ellipsoid there.
  static Eigen::Vector2d half_widths_m(const ProbeGeometry& probe, double depth_m) {
    const Vec3 e = semi_axes_m(probe);
    const PrincipalCurvature tip = principal(probe);
    Eigen::Vector2d out;
    for (int i = 0; i < 2; ++i)
      out[i] = std::min(std::sqrt(depth_m * tip.radius_m[i]), e.cwiseProduct(tip.along[i]).norm());
    if (out[0] > out[1]) std::swap(out[0], out[1]);
    return out;
  }

  static double contact_radius_m(const ProbeGeometry& probe, double depth_m) {
    return half_widths_m(probe, depth_m)[0];
  }
  static double mesh_length_m(const ProbeGeometry& probe, double depth_m) {
    return contact_radius_m(probe, depth_m);
  }
  static double contact_reach_m(const ProbeGeometry& probe, double depth_m) {
    return half_widths_m(probe, depth_m)[1];
  }
  static double tip_radius_m(const ProbeGeometry& probe) {
    return std::min(principal(probe).radius_m[0], half_width_m(probe));
  }
  static double half_width_m(const ProbeGeometry& probe) {
    const PrincipalCurvature tip = principal(probe);
    const Vec3 e = semi_axes_m(probe);
    return std::max(e.cwiseProduct(tip.along[0]).norm(), e.cwiseProduct(tip.along[1]).norm());
  }

 private:
  /// Radii of curvature at the reference point, smallest first, and their directions (own axes).
  struct PrincipalCurvature {
    std::array<double, 2> radius_m;
    std::array<Vec3, 2> along;
  };
  static PrincipalCurvature principal(const ProbeGeometry& probe) {
    Vec3 normal;
    const Mat3 curvature = normal_derivative(semi_axes_m(probe), probe.touch, normal);
    const auto [values, vectors] = symmetric_eigen(curvature);  // 0 along the normal comes first
    return {{1 / values[2], 1 / values[1]}, {vectors.col(2), vectors.col(1)}};
  }
};

}  // namespace palpate::fem
