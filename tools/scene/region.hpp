#pragma once

#include <string>
#include <variant>
#include <vector>

#include "libfit/core/geometry.hpp"

namespace palpate::tools {

/// A part of space named by a scene: what is held, what is reachable, what an inclusion fills.
struct HalfSpace {
  int axis = 2;
  double at_m = 0;
  bool is_below = true;
};
struct Box {
  Vec3 low_m = Vec3::Zero(), high_m = Vec3::Zero();
};
struct Ball {
  Vec3 center_m = Vec3::Zero();
  double radius_m = 0;
};
using Region = std::variant<HalfSpace, Box, Ball>;

/// Borders belong to the region.
bool contains(const Region& region, const Vec3& point);
bool any_contains(const std::vector<Region>& regions, const Vec3& point);

}  // namespace palpate::tools
