#include "tools/scene/region.hpp"

#include <algorithm>
#include <utility>

#include "libfit/core/closest_point.hpp"

namespace palpate::tools {
namespace {

template <class... F>
struct Overloaded : F... {
  using F::operator()...;
};
template <class... F>
Overloaded(F...) -> Overloaded<F...>;

}  // namespace

Enclosed::Enclosed(Surface closed) : surface(std::move(closed)), boxes(triangle_boxes(surface)) {}

bool contains(const Region& region, const Vec3& point) {
  return std::visit(
      Overloaded{
          [&](const HalfSpace& r) {
            return r.is_below ? point[r.axis] <= r.at_m : point[r.axis] >= r.at_m;
          },
          [&](const Box& r) {
            return (point.array() >= r.low_m.array()).all() &&
                   (point.array() <= r.high_m.array()).all();
          },
          [&](const Ball& r) {
            return (point - r.center_m).squaredNorm() <= r.radius_m * r.radius_m;
          },
          [&](const Solid& r) { return is_inside(r.boundary->surface, r.boundary->boxes, point); },
          [&](const Marked& r) { return r.part->contains(point); },
      },
      region);
}

std::optional<Vec3> center_of(const std::optional<SurfaceRegion>& region) {
  const Ball* ball = region && region->part ? std::get_if<Ball>(&*region->part) : nullptr;
  return ball != nullptr ? std::optional(ball->center_m) : std::nullopt;
}

Vec3 outward_of_side(std::string_view side) {
  return (side[0] == '-' ? -1.0 : 1.0) * Vec3::Unit(side[1] - 'x');
}

bool any_contains(const std::vector<Region>& regions, const Vec3& point, bool is_on_boundary) {
  return std::any_of(regions.begin(), regions.end(), [&](const Region& region) {
    const auto* marked = std::get_if<Marked>(&region);
    return (is_on_boundary || marked == nullptr || !marked->part->is_on_faces()) &&
           contains(region, point);
  });
}

}  // namespace palpate::tools
