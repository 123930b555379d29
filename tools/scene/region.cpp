#include "tools/scene/region.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace palpate::tools {
namespace {

template <class... F>
struct Overloaded : F... {
  using F::operator()...;
};
template <class... F>
Overloaded(F...) -> Overloaded<F...>;

}  // namespace

bool contains(const Region& region, const Vec3& point) {
  return std::visit(Overloaded{
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
                    },
                    region);
}

bool any_contains(const std::vector<Region>& regions, const Vec3& point) {
  return std::any_of(regions.begin(), regions.end(),
                     [&](const Region& region) { return contains(region, point); });
}

std::string canonical(const Region& region) {
  return std::visit(Overloaded{
                        [](const HalfSpace& r) {
                          return fmt::format("{} {} {}", r.is_below ? "below" : "above", r.axis,
                                             r.at_m);
                        },
                        [](const Box& r) {
                          return fmt::format("box {} {} {} {} {} {}", r.low_m[0], r.low_m[1],
                                             r.low_m[2], r.high_m[0], r.high_m[1], r.high_m[2]);
                        },
                        [](const Ball& r) {
                          return fmt::format("sphere {} {} {} {}", r.center_m[0], r.center_m[1],
                                             r.center_m[2], r.radius_m);
                        },
                    },
                    region);
}

}  // namespace palpate::tools
