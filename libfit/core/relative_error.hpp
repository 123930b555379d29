#pragma once

#include <algorithm>

namespace palpate {

/// What a person does not feel [N]: the floor of the force's just noticeable difference
/// (docs/method.md, 8).
inline constexpr double kForceFloor_N = 0.04;
/// Just noticeable difference of a force, as a share of it (docs/method.md, 8).
inline constexpr double kForceJnd = 0.07;
/// A point's light touches, as a share of its typical or largest force: their errors count against
/// this floor.
inline constexpr double kLightForce = 0.05;

/// The one relative error (M11a): |difference| over |reference|, and where the reference is below a
/// floor, over the floor. Without one the first rows of a press, where force
/// goes to zero, would be all that a quantile sees. error, force and floor: in one unit, not
/// negative.
inline double relative_error(double error, double force, double floor) {
  return error / std::max(force, floor);
}

/// Whether a person cannot tell an answer this far off from a force [N].
inline bool is_within_jnd(double error_N, double force_N) {
  return error_N <= std::max(kForceFloor_N, kForceJnd * force_N);
}

}  // namespace palpate
