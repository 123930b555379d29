#pragma once

#include <algorithm>
#include <cmath>

#include "libfit/core/geometry.hpp"

namespace palpate::bodies {

// Fields in mm, negative inside, about a distance near their surface.

// max(a, b), its corner rounded over a band of width k with continuous curvature
// (Quilez, "smooth minimum", cubic).
inline double rounded_max(double a, double b, double k) {
  const double h = std::max(k - std::abs(a - b), 0.0) / k;
  return std::max(a, b) + h * h * h * k / 6;
}
inline double rounded_min(double a, double b, double k) { return -rounded_max(-a, -b, k); }

inline double ellipsoid(const Vec3& x, const Vec3& centre, const Vec3& radii) {
  const Vec3 p = x - centre;
  const double k0 = p.cwiseQuotient(radii).norm();
  const double k1 = p.cwiseQuotient(radii.cwiseProduct(radii)).norm();
  return k1 > 1e-9 ? k0 * (k0 - 1) / k1 : -radii.minCoeff();
}

}  // namespace palpate::bodies
