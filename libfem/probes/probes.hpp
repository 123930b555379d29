#pragma once

#include <span>
#include <string>
#include <string_view>

#include "libfit/core/geometry.hpp"

namespace palpate::fem {

/// Signed distance to a probe's surface and its derivatives at one place.
/// distance_m > 0 outside; gradient is the probe's outward unit normal there; hessian [1/m] is the
/// curvature of the distance field, which contact stiffness needs.
struct SignedDistance {
  double distance_m = 0;
  Vec3 gradient = Vec3::Zero();
  Mat3 hessian = Mat3::Zero();
};

/// A rigid tool shape. It is placed by its reference point x (the point that touches first on a
/// flat surface) and the unit axis u that points into the body.
/// signed_distance: at `offset` from the reference point [m]. bounding_radius_m and its centre:
/// a ball about reference point + centre_along_axis * radius * u that holds the part that presses.
struct ShapeRow {
  std::string_view name, summary;
  SignedDistance (*signed_distance)(double radius_m, const Vec3& axis, const Vec3& offset);
  double centre_along_axis;  ///< in radii
  double bounding_radius;    ///< in radii
};

/// Every shape there is.
std::span<const ShapeRow> probe_shapes();

/// The shape's row. Throws Error at `where` naming the known shapes.
const ShapeRow& find_shape(std::string_view name, const std::string& where);

/// The tool of an experiment. friction: Coulomb coefficient of the interface, 0 for none.
struct Probe {
  const ShapeRow* shape = nullptr;
  double radius_m = 0;
  double friction = 0;
};

/// Looks the shape up and checks its numbers. Throws Error at `where` when the shape is unknown,
/// the radius is not positive or the friction is negative.
Probe make_probe(std::string_view shape, double radius_m, double friction, const std::string& where);

}  // namespace palpate::fem
