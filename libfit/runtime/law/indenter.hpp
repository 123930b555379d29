// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// A rigid tool's round end, as contact mechanics sees it (docs/method-tools.md, section 30): how
// deep it stands when its contact with an even body has radius a. Of any profile f(r), its height
// over the point that touches first (Sneddon 1965, doi:10.1016/0020-7225(65)90019-4),
//
//     d(a) = a int_0^a f'(r) / sqrt(a^2 - r^2) dr          of a ball a atanh(a / R)         (M80)
//
// Only + - * / and sqrt are used, so bits are the same everywhere.

#include "../base/constants.hpp"
#include "../base/scalar.hpp"

namespace palpate::runtime {

/// points: of the profile, 0 for a ball; between them f' is linear, from f'(0) = 0 on; beyond the
/// last one stands a wall.
struct Indenter {
  double round_end_m = 0;  ///< radius of the ball that it ends with; 0: it ends flat
  int points = 0;
  double r_m[kMaxProfilePoints] = {};    ///< rising, the first 0
  double slope[kMaxProfilePoints] = {};  ///< f' there, >= 0
};

inline Indenter ball_indenter(double radius_m) noexcept {
  Indenter out;
  out.round_end_m = radius_m;
  return out;
}

inline bool is_possible(const Indenter& tool) noexcept {
  if (!(tool.round_end_m >= 0 && tool.round_end_m <= 1e3)) return false;
  if (tool.points == 0) return tool.round_end_m > 0;
  if (tool.points < 2 || tool.points > kMaxProfilePoints || tool.r_m[0] != 0 || tool.slope[0] != 0)
    return false;
  for (int i = 1; i < tool.points; ++i)
    if (!(tool.r_m[i] > tool.r_m[i - 1] && tool.r_m[i] <= 1e3) ||
        !(tool.slope[i] >= tool.slope[i - 1] && tool.slope[i] <= 1e6))
      return false;
  return tool.slope[tool.points - 1] > 0;
}

/// atanh of 0 <= x < 1: halved until its series is short.
inline double atanh_of(double x) noexcept {
  double factor = 1;
  for (int i = 0; i < 60 && x > 0.03; ++i) {
    x = x / (1 + std::sqrt(1 - x * x));
    factor *= 2;
  }
  const double s = x * x;
  return factor * x * (1 + s * (1.0 / 3 + s * (1.0 / 5 + s * (1.0 / 7 + s * (1.0 / 9 + s / 11)))));
}
/// tanh of y >= 0.
inline double tanh_of(double y) noexcept {
  int doublings = 0;
  for (; doublings < 40 && y > 0.03; ++doublings) y *= 0.5;
  const double s = y * y;
  double t = y * (1 - s * (1.0 / 3 - s * (2.0 / 15 - s * (17.0 / 315 - s * (62.0 / 2835)))));
  for (; doublings > 0; --doublings) t = 2 * t / (1 + t * t);
  return t;
}
/// asin of 0 <= x <= 1.
inline double asin_of(double x) noexcept {
  double factor = 1;
  for (int i = 0; i < 60 && x > 0.03; ++i) {
    const double cosine = std::sqrt((1 - x) * (1 + x));
    x = x / std::sqrt(2 * (1 + cosine));
    factor *= 2;
  }
  const double s = x * x;
  return factor * x * (1 + s * (1.0 / 6 + s * (3.0 / 40 + s * (15.0 / 336 + s * (105.0 / 3456)))));
}
/// log of x > 0, to 1e-13 within a factor 100 of 1.
inline double log_of(double x) noexcept {
  const double t = (x - 1) / (x + 1);
  return t < 0 ? -2 * atanh_of(-t) : 2 * atanh_of(t);
}

/// The widest contact that the tool can have [m].
inline double widest_m(const Indenter& tool) noexcept {
  return tool.points > 0 ? tool.r_m[tool.points - 1] : tool.round_end_m;
}

/// (M80) at a >= 0 [m]; kNeverDeep_m beyond what the tool can have.
inline double depth_at(const Indenter& tool, double a) noexcept {
  if (!(a > 0)) return 0;
  if (tool.points == 0)
    return a < tool.round_end_m ? a * atanh_of(a / tool.round_end_m) : kNeverDeep_m;
  if (a > widest_m(tool)) return kNeverDeep_m;
  double sum = 0, angle = 0, height = a;  // asin(r / a) and sqrt(a^2 - r^2) at the segment's begin
  for (int i = 1; i < tool.points && tool.r_m[i - 1] < a; ++i) {
    const double from = tool.r_m[i - 1], to = tool.r_m[i] < a ? tool.r_m[i] : a;
    const double rise = (tool.slope[i] - tool.slope[i - 1]) / (tool.r_m[i] - from);
    const double next = asin_of(to / a), low = std::sqrt((a - to) * (a + to));
    sum += (tool.slope[i - 1] - rise * from) * (next - angle) + rise * (height - low);
    angle = next;
    height = low;
  }
  return a * sum;
}

/// Its inverse: the contact's radius [m] at a depth > 0, at most widest_m().
inline double contact_radius_at(const Indenter& tool, double depth_m) noexcept {
  double lo = 0, hi = widest_m(tool);
  if (tool.points > 0 && !(depth_at(tool, hi) > depth_m)) return hi;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (lo + hi);
    (depth_at(tool, middle) < depth_m ? lo : hi) = middle;
  }
  return hi;
}

/// Radius of the ball whose contact has radius a where it is as deep [m].
inline double ball_as_deep(double a, double depth_m) noexcept { return a / tanh_of(depth_m / a); }

/// Steepness of a tool in the body: depth over the contact's radius, a / R of a shallow ball.
inline double steepness_at(const Indenter& tool, double depth_m) noexcept {
  return depth_m / contact_radius_at(tool, depth_m);
}
/// Depth up to most_m at which it is `steepest`.
inline double depth_of_steepness(const Indenter& tool, double steepest, double most_m) noexcept {
  if (steepness_at(tool, most_m) <= steepest) return most_m;
  double lo = 0, hi = most_m;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (lo + hi);
    (steepness_at(tool, middle) < steepest ? lo : hi) = middle;
  }
  return lo;
}

/// The deepest that another tool is known for, where a ball was pressed to depth_m.
inline double known_depth_m(const Indenter& tool, double ball_m, double depth_m) noexcept {
  return depth_of_steepness(tool, kMaxSteepness * steepness_at(ball_indenter(ball_m), depth_m),
                            depth_m);
}

}  // namespace palpate::runtime
