#include "libfit/core/misread_unit.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "libfit/core/closest_point.hpp"
#include "libfit/core/units.hpp"

namespace palpate {
namespace {

constexpr std::array<std::string_view, 3> kUnits{"mm", "cm", "um"};
constexpr double kFarTooLong = 10;
constexpr Eigen::Index kMostPlaces = 500;  // of a path that are looked at

}  // namespace

std::optional<std::string_view> misread_unit(const Points& places_m, const Surface& body) {
  if (places_m.rows() == 0 || body.triangles.rows() == 0) return std::nullopt;
  const double size_m = extent_m(body.vertices).norm();
  const Eigen::Array3d low = body.vertices.colwise().minCoeff(),
                       high = body.vertices.colwise().maxCoeff();
  const auto is_within = [&](double sizes, const Vec3& place) {
    return (place.array() >= low - sizes * size_m).all() &&
           (place.array() <= high + sizes * size_m).all();
  };
  for (const auto& place : places_m.rowwise())
    if (is_within(kFarTooLong, place)) return std::nullopt;
  const BoxTree boxes = triangle_boxes(body);
  std::optional<std::string_view> unit;
  double best = std::numeric_limits<double>::infinity();
  const Eigen::Index stride = std::max<Eigen::Index>(1, places_m.rows() / kMostPlaces);
  for (const std::string_view name : kUnits)
    for (Eigen::Index i = 0; i < places_m.rows(); i += stride) {
      const Vec3 place = *unit_factor(name, Dimension::length) * places_m.row(i);
      if (!is_within(1, place)) continue;
      const double off = closest_point(body, boxes, place)->distance_m / place.norm();
      if (off < best) best = off, unit = name;
    }
  return unit;
}

std::optional<std::string_view> misread_unit(double length_m, const Vec3& extent_m) {
  if (length_m < kFarTooLong * extent_m.maxCoeff()) return std::nullopt;
  for (const std::string_view name : {"mm", "um"})
    if (length_m * *unit_factor(name, Dimension::length) <= extent_m.maxCoeff()) return name;
  return std::nullopt;
}

}  // namespace palpate
