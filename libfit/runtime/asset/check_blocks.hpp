// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// What is checked of the blocks that lie behind an asset's sections, where it has them: how a body
// relaxes and is damaged, curves over the lean, how tools feel each other.

#include <cmath>

#include "../status.hpp"
#include "../sway.hpp"
#include "view.hpp"

namespace palpate {
namespace runtime {

/// A Prony series that rings can follow: what the block says and nothing beside it.
inline Status check_relaxation(const AssetView& view, const Header& h, const void* bytes) noexcept {
  if ((h.flags & kFlagRelaxation) == 0) return Status::ok;
  const auto block = block_at<RelaxationBlock>(bytes, h, relaxation_at);
  if (h.family != int(Family::rings) || view.curves.relaxation.branches == 0 || block.reserved != 0)
    return Status::numbers_wrong;
  for (int k = 0; k < kMaxBranches; ++k) {
    if (k >= block.branches) {
      if (block.share[k] != 0 || block.time_s[k] != 0) return Status::numbers_wrong;
      continue;
    }
    const double least_s = k > 0 ? block.time_s[k - 1] : 0;
    if (!(block.share[k] > 0 && block.share[k] <= kMaxShare) ||
        !(block.time_s[k] >= kMinRelaxation_s && block.time_s[k] <= kMaxRelaxation_s) ||
        !(block.time_s[k] > least_s))
      return Status::numbers_wrong;
  }
  return Status::ok;
}

/// Numbers that damage can follow: what the block says and nothing beside it.
inline Status check_damage(const Header& h, const void* bytes) noexcept {
  if ((h.flags & kFlagDamage) == 0) return Status::ok;
  const auto block = block_at<DamageBlock>(bytes, h, damage_at);
  const auto is_within = [](double x, double least, double most) noexcept {
    return x >= least && x <= most;
  };
  const bool softens = is_within(block.r, kMinDamage, kMaxDamage) &&
                       is_within(block.scale, 0, kMaxDamage) &&
                       is_within(block.beta, 0, kMaxDamage) && block.scale + block.beta > 0 &&
                       is_within(block.reach_m, 0, kMaxDamageReach_m);
  const bool punctures = block.puncture_N > 0 && block.puncture_N <= kMaxPuncture_N &&
                         is_within(block.cutting_N, 0, block.puncture_N) &&
                         is_within(block.friction_N_m, 0, kMaxShaftFriction_N_m) &&
                         block.mouth_m > 0 && block.mouth_m <= kMaxDamageReach_m;
  const bool is_hard = block.r == 0 && block.scale == 0 && block.beta == 0 && block.reach_m == 0;
  const bool is_whole = block.puncture_N == 0 && block.cutting_N == 0 && block.friction_N_m == 0 &&
                        block.mouth_m == 0;
  const bool is_good = (softens || is_hard) && (punctures || is_whole) && !(is_hard && is_whole);
  return is_good ? Status::ok : Status::numbers_wrong;
}

/// Whether the side force of a vertex is one that its press can bear: (M22) at the end of the
/// curves, the lateral deflection as long as the depth, with room for what a fit leaves to
/// `check --repair`. Beyond it forces have nothing to do with a body's.
constexpr double kSideSlack = 100;
inline bool is_side_borne(const SplineView& normal, const float* curve, const float* side2,
                          const float* side3) noexcept {
  const double d = normal.knots[normal.pieces], most_N = double(curve[normal.size() - 1]);
  const auto length = [](const float* g) noexcept {
    return std::sqrt(double(g[0]) * g[0] + double(g[1]) * g[1] + double(g[2]) * g[2]);
  };
  return d * d * (2 * length(side2) + 3 * length(side3) * d) <= kSideSlack * most_N;
}

/// Rising sines, and at every node of a vertex's lean curves that the family admits.
inline Status check_leans(const AssetView& view, const Header& h, const void* bytes) noexcept {
  if (h.tilts == 0) return Status::ok;
  const auto block = block_at<LeanBlock>(bytes, h, leans_at);
  double before = 0;
  for (int j = 0; j < kMaxTilts; ++j) {
    const bool is_good =
        j < h.tilts ? block.sine[j] > before && block.sine[j] < 1 : block.sine[j] == 0;
    if (!is_good) return Status::numbers_wrong;
    before = block.sine[j];
  }
  for (const double reserved : block.reserved)
    if (reserved != 0) return Status::numbers_wrong;
  const Part* part = family_of(h).part;
  const int size = part_size(h, kNormal), nodes = view.leans.nodes.size();
  for (int v = 0; v < view.vertices; ++v) {
    const std::ptrdiff_t row = std::ptrdiff_t{view.record[v]} * nodes;
    for (int i = 0; i < nodes; ++i) {
      const float* curve = view.leans.control + (row + i) * (size + kLeanSideNumbers);
      if (!is_good_part(part[kNormal], curve, size, !view.covered[v]) ||
          !is_good_part(part[kSide2], curve + size, 1, !view.covered[v]) ||
          !is_good_part(part[kSide3], curve + size + 3, 1, !view.covered[v]) ||
          !is_side_borne(view.curves.view[kNormal], curve, curve + size, curve + size + 3))
        return Status::controls_wrong;
    }
  }
  const auto* numbers = reinterpret_cast<const unsigned char*>(view.leans.control);
  for (std::uint64_t i = 4 * lean_numbers(h); i < aligned(4 * lean_numbers(h)); ++i)
    if (numbers[i] != 0) return Status::numbers_wrong;
  return Status::ok;
}

/// By how much coupling is too strong for the stiffest vertex; 1 or less: it is not (M62).
inline double coupling_excess(const AssetView& view, const CouplingView& coupling) noexcept {
  double most = 0;
  for (int v = 0; v < view.vertices; ++v) {
    if (view.covered[v] == 0) continue;
    const float* node = view.node(v);
    const SplineView& spline = view.curves.view[kNormal];
    const double along =
        curve_slope(spline, node + view.control_offset[kNormal], spline.knots[spline.pieces]);
    const double excess =
        coupling_excess(coupling, along, along * double(node[view.control_offset[kLambda]]));
    most = excess > most ? excess : most;
  }
  return most;
}
constexpr double kCouplingSlack = 1.001;  ///< what was made small enough before it was rounded is

/// Numbers that coupling can follow, on rings that neither relax nor soften.
inline Status check_coupling(const AssetView& view, const Header& h, const void* bytes) noexcept {
  if ((h.flags & kFlagCoupling) == 0) return Status::ok;
  const auto block = block_at<CouplingBlock>(bytes, h, coupling_block_at);
  for (const double reserved : block.reserved)
    if (reserved != 0) return Status::numbers_wrong;
  const bool is_good = (h.flags & (kFlagRelaxation | kFlagDamage)) == 0 &&
                       view.curves.family == static_cast<int>(Family::rings) &&
                       is_possible(*view.coupling) &&
                       coupling_excess(view, *view.coupling) <= kCouplingSlack;
  return is_good ? Status::ok : Status::numbers_wrong;
}

}  // namespace runtime
}  // namespace palpate
