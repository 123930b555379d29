#pragma once

#include <algorithm>
#include <cmath>

namespace palpate {

// How experiments are followed with the engine, to compare its answers.

inline constexpr double kWalkTick_m = 20e-6;   ///< most that a tool moves: 20 mm/s at 1 kHz
inline constexpr double kApproachRatio = 0.1;  ///< of the depth, from outside, before the first row
/// Of the largest force of an experiment: errors of lighter rows are over this.
inline constexpr double kLightRow = 0.1;

/// Ticks over a way [m]; at least one.
inline int ticks_over(double way_m) {
  return std::max(1, static_cast<int>(std::ceil(way_m / kWalkTick_m)));
}

}  // namespace palpate
