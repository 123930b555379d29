#include "tools/scene/region.hpp"

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

}  // namespace palpate::tools
