#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "libfit/core/body.hpp"
#include "libfit/core/probe.hpp"
#include "libfit/core/samples.hpp"

namespace palpate {

/// Experiments that no fit saw, for validation.
struct HeldOut {
  TestPoints points;            ///< contact points on the body's facets, blended inward normals
  std::vector<ToolPath> paths;  ///< one per point
};

struct HeldOutRange {
  double depth_m = 0;          ///< deepest press; paths reach 0.5 to 0.95 of it
  double drag_distance_m = 0;  ///< longest drag; slides reach 0.5 to 1 of it
  /// True where the tool can touch; another point is drawn where not. Empty: everywhere.
  std::function<bool(const Vec3& position, const Vec3& inward)> can_touch = {};
  double tilt_rad = 0;  ///< up to which the tool leans on tilting paths; 0: there are none
  /// The same of a tool that leans; empty: everywhere.
  std::function<bool(const Vec3& position, const Vec3& inward, const Lean& lean)> can_lean = {};
  /// Of each triangle of the body, how much it changes there [1/m]: points are drawn on the fifth
  /// of the reachable area that has most. Empty: everywhere.
  std::vector<double> change = {};
};

/// Contact points uniform by area over triangles whose three vertices are reachable, each with one
/// path that keeps the contact point where it can be reached: a straight press; an oblique one, 20
/// to 45 degrees off the normal; a press that goes on while it slides; a press dragged there and
/// back beyond where it began, each in a random tangential direction; a press that wanders over six
/// random places within the drag distance, by turns retracted in part, down to 0.2 of the depth,
/// and pressed on. Tilting paths come last, at points of their own, as many as of each other kind:
/// presses and sliding ones by turns, leaning by 0 to tilt_rad in any direction. Seeded, and
/// nothing but the body counts: every asset of a body meets the same ones. Throws Error when no
/// triangle is reachable, or the tool can touch at none of 1000 points drawn one after the
/// other.
HeldOut draw_held_out(const Body& body, const HeldOutRange& range, int points, std::uint64_t seed);

/// First letter of the names of points of draw_sliding(); that of all others is another.
inline constexpr char kChangeName = 'c';

/// Paths back and forth and wandering ones, by turns, at points drawn as those of draw_held_out.
HeldOut draw_sliding(const Body& body, const HeldOutRange& range, int paths, std::uint64_t seed);

/// Paths of a tool that leans by 0 to range.tilt_rad in any direction: at points drawn as those of
/// draw_held_out, of the upright kinds in turn, each where range.can_lean.
HeldOut draw_leaning(const Body& body, const HeldOutRange& range, int paths, std::uint64_t seed);

/// Paths of two tools side by side: the second presses and stays, the first presses beside it, and
/// then one of them, by turns, is dragged. Their distances rise in even shares from least_m to
/// most_m, or are drawn from there where is_drawn (seeded), as far as the region has such places.
HeldOut draw_two_tools(const Body& body, const HeldOutRange& range, int paths, double least_m,
                       double most_m, bool is_drawn, std::uint64_t seed);

}  // namespace palpate
