// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// What is checked of the blocks that lie behind an asset's sections, where it has them: how a body
// relaxes and softens, how contacts on it move each other.

#include <cmath>

#include "../base/status.hpp"
#include "../law/compliance.hpp"
#include "view.hpp"

namespace palpate {
namespace runtime {

/// A Prony series that rings can follow: what the block says and nothing beside it.
inline Status check_block(const AssetView& view, const Header& h,
                          const RelaxationBlock& block) noexcept {
  if (h.family != int(Family::rings) || view.curves.relaxation.branches == 0 || block.reserved != 0)
    return Status::block_wrong;
  for (int k = 0; k < kMaxBranches; ++k) {
    if (k >= block.branches) {
      if (block.share[k] != 0 || block.time_s[k] != 0) return Status::block_wrong;
      continue;
    }
    const double least_s = k > 0 ? block.time_s[k - 1] : 0;
    if (!(block.share[k] > 0 && block.share[k] <= kMaxShare) ||
        !(block.time_s[k] >= kMinRelaxation_s && block.time_s[k] <= kMaxRelaxation_s) ||
        !(block.time_s[k] > least_s))
      return Status::block_wrong;
  }
  return Status::ok;
}

/// Numbers that damage can follow: what the block says and nothing beside it.
inline Status check_block(const AssetView&, const Header&, const DamageBlock& block) noexcept {
  const auto is_within = [](double x, double least, double most) noexcept {
    return x >= least && x <= most;
  };
  bool is_good = is_within(block.r, kMinDamage, kMaxDamage) &&
                 is_within(block.scale, 0, kMaxDamage) && is_within(block.beta, 0, kMaxDamage) &&
                 block.scale + block.beta > 0 && is_within(block.reach_m, 0, kMaxDamageReach_m);
  for (const double reserved : block.reserved) is_good = is_good && reserved == 0;
  return is_good ? Status::ok : Status::block_wrong;
}

/// Whether the side force of a vertex is one that its press can bear: (M22) at the end of the
/// curves, the lateral deflection as long as the depth, with room for what a fit leaves to
/// the guard. Beyond it forces have nothing to do with a body's.
constexpr double kSideSlack = 100;
inline bool is_side_borne(const SplineView& normal, const float* curve, const float* side2,
                          const float* side3) noexcept {
  const double d = normal.knots[normal.pieces], most_N = double(curve[normal.size() - 1]);
  const auto length = [](const float* g) noexcept {
    return std::sqrt(double(g[0]) * g[0] + double(g[1]) * g[1] + double(g[2]) * g[2]);
  };
  return d * d * (2 * length(side2) + 3 * length(side3) * d) <= kSideSlack * most_N;
}

/// Numbers that coupling can follow, on rings.
inline Status check_block(const AssetView&, const Header& h, const CouplingBlock& block) noexcept {
  for (const double reserved : block.reserved)
    if (reserved != 0) return Status::block_wrong;
  const bool is_good = h.family == static_cast<int>(Family::rings) && is_possible(block.coupling);
  return is_good ? Status::ok : Status::block_wrong;
}

/// Of all blocks that the asset has; its sections are checked.
template <class... Each>
Status check_blocks(const AssetView& view, const Header& h, const void* bytes,
                    AssetBlocks<Each...>) noexcept {
  Status status = Status::ok;
  const auto check = [&](const auto* block) noexcept {
    if (status == Status::ok && block != nullptr) status = check_block(view, h, *block);
  };
  (check(block_of<Each>(bytes, h)), ...);
  return status;
}

}  // namespace runtime
}  // namespace palpate
