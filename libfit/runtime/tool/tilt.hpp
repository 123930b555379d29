// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// Energy over the tilt of a tool that is round about its axis (docs/method.md, section 27): leans
// in the frame of a place, and the basis on the disc of leans that curves are weighted by (M59).
// Weights are C1, never negative and sum to 1, so what is admissible of curves (rising, stable,
// stored energy above 0) holds at every lean. One template for the engine and the fitter; no
// function that differs between compilers.

#include "../scalar.hpp"

namespace palpate {
namespace runtime {

constexpr int kMaxTilts = 3;        ///< beside upright
constexpr int kTiltDirections = 3;  ///< evenly around
constexpr int kMaxTiltNodes = 1 + kMaxTilts * kTiltDirections;
constexpr double kTiltPole = 1e-9;  ///< 1 + n_z below which a place has the pole's frame

/// Two tangents t_1, t_2 at a place with the inward unit normal u (M58b): the least turn from z to
/// the outward normal takes x and y there.
struct TiltFrame {
  Vec3d first, second;
};
inline TiltFrame tilt_frame(const Vec3d& inward) noexcept {
  const Vec3d n = inward * -1.0;
  const Vec3d middle{n.x, n.y, n.z + 1};
  const Vec3d x{1, 0, 0};
  const Vec3d first = middle.z > kTiltPole ? x - middle * (n.x / middle.z) : x;
  return {first, cross(n, first)};
}

/// Sine of the tilt times the direction in which the shaft leans.
struct TiltLean {
  double first, second;
};
/// shaft: unit, from the tip along the tool, out of the body.
inline TiltLean lean_of(const TiltFrame& frame, const Vec3d& shaft) noexcept {
  return {dot(frame.first, shaft), dot(frame.second, shaft)};
}
/// The torque on the body that an energy's slope by the lean [J] makes of turning the tool (M60).
inline Vec3d tilt_torque(const TiltFrame& frame, const Vec3d& shaft,
                         const TiltLean& slope_J) noexcept {
  return cross(shaft, frame.first) * slope_J.first + cross(shaft, frame.second) * slope_J.second;
}

/// Leans with curves of their own: node 0 is upright, node 1 + 3 (j - 1) + k leans by sine[j] to
/// the direction k; sine[0] = 0, rising.
struct TiltNodes {
  int tilts = 0;  ///< beside upright, 1 to kMaxTilts
  double sine[kMaxTilts + 1] = {0, 0, 0, 0};

  int size() const noexcept { return 1 + kTiltDirections * tilts; }
  TiltLean lean(int node) const noexcept;
};

/// cos and sin of 0, 120 and 240 degrees.
constexpr double kTiltCos[kTiltDirections] = {1, -0.5, -0.5};
constexpr double kTiltSin[kTiltDirections] = {0, 0.86602540378443865, -0.86602540378443865};

inline TiltLean TiltNodes::lean(int node) const noexcept {
  if (node == 0) return {0, 0};
  const int k = (node - 1) % kTiltDirections;
  const double r = sine[1 + (node - 1) / kTiltDirections];
  return {r * kTiltCos[k], r * kTiltSin[k]};
}

/// Weights of the nodes' control curves and their slopes by the lean.
struct TiltWeights {
  double w[kMaxTiltNodes] = {}, d_first[kMaxTiltNodes] = {}, d_second[kMaxTiltNodes] = {};
};

/// Where the splines over the sine have their knots: half way between nodes, mirrored at 0, and as
/// far beyond the last node (M59a).
inline double tilt_knot(const TiltNodes& nodes, int j) noexcept {
  if (j <= 0) return -tilt_knot(nodes, 1 - j);
  const int n = nodes.tilts > 1 ? nodes.tilts : 1;
  if (j <= n) return 0.5 * (nodes.sine[j - 1] + nodes.sine[j]);
  return 2 * nodes.sine[n] - 0.5 * (nodes.sine[n - 1] + nodes.sine[n]);
}

/// A quadratic ramp from 0 at knot j - 1 to 1 at knot j + 1, and its slope.
inline Dual tilt_ramp(const TiltNodes& nodes, int j, double r) noexcept {
  const double a = tilt_knot(nodes, j - 1), b = tilt_knot(nodes, j), c = tilt_knot(nodes, j + 1);
  if (r <= a) return Dual(0);
  if (r >= c) return Dual(1);
  if (r < b) {
    const double up = 1 / ((c - a) * (b - a));
    return Dual((r - a) * (r - a) * up, 2 * (r - a) * up);
  }
  const double down = 1 / ((c - a) * (c - b));
  return Dual(1 - (c - r) * (c - r) * down, 2 * (c - r) * down);
}

/// (M59a): quadratic B-splines of the sine, even for the mean over directions and odd for its
/// first harmonic, which is all that three directions tell.
inline TiltWeights tilt_weights(const TiltNodes& nodes, const TiltLean& lean) noexcept {
  TiltWeights out;
  const double squared = lean.first * lean.first + lean.second * lean.second;
  const double r = std::sqrt(squared);
  const double per = r > 0 ? 1 / r : 0, away[2] = {lean.first * per, lean.second * per};
  Dual left(1);
  for (int j = 1; j <= nodes.tilts; ++j) {
    Dual up = tilt_ramp(nodes, j, r), mirrored = tilt_ramp(nodes, j, -r);
    mirrored.v = -mirrored.v;
    if (j < nodes.tilts) {
      const Dual next = tilt_ramp(nodes, j + 1, r);
      up = Dual(up.a - next.a, up.v - next.v);
    }
    const double even = up.a + mirrored.a, deven = up.v + mirrored.v;
    left = Dual(left.a - even, left.v - deven);
    // Odd part over r: constant within the first knot.
    const double odd = up.a - mirrored.a, dodd = up.v - mirrored.v;
    const bool is_middle = r <= tilt_knot(nodes, 1);
    const double share = is_middle ? (j == 1 ? dodd : 0) : odd * per;
    const double dshare = is_middle ? 0 : (dodd - share) * per;
    for (int k = 0; k < kTiltDirections; ++k) {
      const int node = 1 + kTiltDirections * (j - 1) + k;
      const double along = lean.first * kTiltCos[k] + lean.second * kTiltSin[k];
      const double w = (even + share * along) / kTiltDirections;
      out.w[node] = w > 0 ? w : 0;  // below only by rounding
      const double slope = deven + dshare * along;
      out.d_first[node] = (slope * away[0] + share * kTiltCos[k]) / kTiltDirections;
      out.d_second[node] = (slope * away[1] + share * kTiltSin[k]) / kTiltDirections;
    }
  }
  out.w[0] = left.a > 0 ? left.a : 0;
  out.d_first[0] = left.v * away[0];
  out.d_second[0] = left.v * away[1];
  return out;
}

}  // namespace runtime
}  // namespace palpate
