#include "data/generators/bodies.hpp"
#include "data/generators/fields.hpp"
#include "data/generators/implicit_mesh.hpp"

namespace palpate::bodies {
namespace {

// Fuller below (-y) than above, with a nipple, cut off by the chest wall.
double breast(const Vec3& from_origin) {
  const Vec3 x = from_origin + Vec3(0, 0, 20);  // the mesher starts inside, at the origin
  const double lower = ellipsoid(x, {0, -6, 0}, {64, 56, 52});
  const double upper = ellipsoid(x, {0, 10, -2}, {60, 66, 40});
  const double nipple = ellipsoid(x, {0, -10, 46}, {9, 9, 13});
  const double dome = rounded_min(rounded_min(lower, upper, 40), nipple, 14);
  return rounded_max(dome, -x.z(), 12);
}

}  // namespace

Surface breast_mm() {
  return mesh_of_field(breast, {.reach_mm = 100, .radius_mm = 3.2, .distance_mm = 0.2});
}

}  // namespace palpate::bodies
