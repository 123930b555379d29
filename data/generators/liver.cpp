#include <algorithm>
#include <cmath>

#include "data/generators/bodies.hpp"
#include "data/generators/fields.hpp"
#include "data/generators/implicit_mesh.hpp"

namespace palpate::bodies {
namespace {

double capsule(const Vec3& x, const Vec3& from, const Vec3& to, double radius) {
  const Vec3 along = to - from;
  const double t = std::clamp((x - from).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (from + t * along - x).norm() - radius;
}

// The dome under the diaphragm: a big right lobe (+x) running out into a flat left one.
double dome(const Vec3& x) {
  const double right = ellipsoid(x, {24, -3, -6}, {66, 75, 64});
  const double left = ellipsoid(x, {-40, 12, 14}, {63, 56, 36});
  return rounded_min(right, left, 55);
}

// The visceral face looks down, back and left; it arches up over the porta.
double visceral_face(const Vec3& x) {
  const double arch = 15 * std::exp(-std::pow((x.x() + 8) / 48, 2) - std::pow((x.y() + 8) / 42, 2));
  const double height = -34 - 0.40 * (x.x() - 24) - 0.30 * x.y() + arch;
  return (height - x.z()) / std::sqrt(1 + 0.4 * 0.4 + 0.3 * 0.3);
}

double liver(const Vec3& x) {
  double field = rounded_max(dome(x), visceral_face(x), 8.5);
  const double spine = capsule(x, {-18, -96, -120}, {-14, -92, 120}, 40);
  const double gallbladder = capsule(x, {14, 84, -66}, {0, 12, -26}, 11);
  field = rounded_max(field, -spine, 18);
  return rounded_max(field, -gallbladder, 14);
}

}  // namespace

Surface liver_mm() { return mesh_of_field(liver, {.radius_mm = 3.7, .distance_mm = 0.17}); }

}  // namespace palpate::bodies
