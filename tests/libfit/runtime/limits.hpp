#pragma once

// The largest force that the law allows at a place and depth, out of an asset's numbers and of what
// the engine says of its contact: no code of a tick is used.

#include "libfit/runtime/engine.hpp"

namespace palpate::test {

struct Limits {
  double lateral_N, normal_N;
};

/// normal_N: the normal curve at the end of the depths that were fitted. lateral_N: what friction
/// bears, L or mu(d) f^z (B3a), and of rings the side force and what curvature tilts (B2).
/// Not of bodies that relax.
inline Limits limits_of(const runtime::AssetView& asset, const runtime::Output& out) {
  const double d = out.normal_m;
  const bool has_rings = asset.curves.family == int(runtime::Family::rings);
  double normal_N = 0, force_N = 0, limit_N = 0, gamma = 0, number[3] = {};
  double side2[3] = {}, side3[3] = {}, curvature[6] = {};
  for (int k = 0; k < 3; ++k) {
    const float* node = asset.node(asset.corner(out.triangle, k));
    const double w = out.weight[k];
    const auto curve = [&](int kind, double x) {
      return w *
             runtime::curve_value(asset.curves.view[kind], node + asset.control_offset[kind], x);
    };
    normal_N += curve(runtime::kNormal, asset.max_fitted_m);
    force_N += curve(runtime::kNormal, d);
    if (!has_rings) {
      limit_N += curve(runtime::kLimit, d);
      continue;
    }
    const runtime::CornerSpot spot{node, asset.control_offset};
    number[0] += w * spot.control(runtime::kFriction, 0);
    number[1] += w * spot.control(runtime::kFrictionSlope, 0);
    gamma += w * spot.control(runtime::kSpread, 0);
    for (int i = 0; i < 3; ++i) side2[i] += w * spot.control(runtime::kSide2, i);
    for (int i = 0; i < 3; ++i) side3[i] += w * spot.control(runtime::kSide3, i);
    for (int i = 0; i < 6; ++i) curvature[i] += w * spot.control(runtime::kCurvature, i);
  }
  if (!has_rings) return {limit_N, normal_N};
  const auto size = [](const double* v) { return std::hypot(v[0], v[1], v[2]); };
  const double mu = std::max(number[0] + number[1] * d, 0.0), D = std::max(asset.max_fitted_m, d);
  limit_N = mu * force_N;
  // What rings that a press has spread as far as they hold may add to f^z (B1a).
  const double more = 1 + 2 * gamma * D * std::max(number[0] + number[1] * D, 0.0);
  const double pull_N_m = 2 * size(side2) * D + 3 * size(side3) * D * D,  // |g'|
      bend = std::sqrt(2.0) * std::hypot(size(curvature), size(curvature + 3)) * out.lateral_m;
  return {limit_N + size(side2) * d * d + size(side3) * d * d * d +
              bend * (more * force_N + out.lateral_m * pull_N_m),
          more * normal_N + out.lateral_m * pull_N_m};
}

}  // namespace palpate::test
