#include "libfem/probes/probes.hpp"

#include <array>
#include <cmath>

#include "libfem/probes/sphere.hpp"
#include "libfit/core/error.hpp"

namespace palpate::fem {
namespace {

// One row per shape; add a shape by its file and a row.
constexpr std::array<ShapeRow, 1> kShapes{{
    {"sphere", "a ball of the given radius", sphere_signed_distance, -1.0, 1.0},
}};

}  // namespace

std::span<const ShapeRow> probe_shapes() { return kShapes; }

const ShapeRow& find_shape(std::string_view name, const std::string& where) {
  std::string names;
  for (const ShapeRow& row : kShapes) {
    if (row.name == name) return row;
    names += (names.empty() ? "" : ", ") + std::string(row.name);
  }
  throw Error(where, "unknown probe shape \"" + std::string(name) + "\"",
              "Use one of: " + names + ".");
}

Probe make_probe(std::string_view shape, double radius_m, double friction,
                 const std::string& where) {
  const ShapeRow& row = find_shape(shape, where);
  if (!(std::isfinite(radius_m) && radius_m > 0))
    throw Error(where, "radius must be positive, not " + std::to_string(radius_m) + " m",
                "Give the probe's radius with its unit, for example radius = \"5 mm\".");
  if (!(std::isfinite(friction) && friction >= 0))
    throw Error(where, "friction must be zero or positive, not " + std::to_string(friction),
                "Give the Coulomb coefficient of the interface, 0 for none.");
  return {&row, radius_m, friction};
}

}  // namespace palpate::fem
