#pragma once

#include "libfem/probes/probes.hpp"

namespace palpate::fem {

/// Ball of radius R whose lowest point along the axis u is the reference point: centre = x - R u.
inline SignedDistance sphere_signed_distance(double radius_m, const Vec3& axis, const Vec3& offset) {
  const Vec3 from_centre = offset + radius_m * axis;
  const double r = from_centre.norm();
  SignedDistance out;
  out.distance_m = r - radius_m;
  if (r < 1e-9 * radius_m) return out;  // the centre: no direction, and no contact can act there
  out.gradient = from_centre / r;
  out.hessian = (Mat3::Identity() - out.gradient * out.gradient.transpose()) / r;
  return out;
}

}  // namespace palpate::fem
