// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The body's compliance under the contacts of a tick (docs/method-body.md, section 21,
// docs/method-tools.md, section 28): C between them, its energy, and the flow of its dashpots
// where the body relaxes. All of it is in the space of forces: a branch k of contact i has flowed
// as far as the force w_k would press it, so one C serves sway and coupling, springs and dashpots.

#include "../contact/contact.hpp"
#include "root.hpp"

namespace palpate::runtime {

/// A place where contacts move each other.
struct CouplingPlace {
  Vec3d point, normal;  ///< relative to the asset's origin; inward unit
  double share;         ///< s of (M62)
  ComplianceRoot root;  ///< of the sway
};

/// asset: that of the ball; it has a coupling.
inline CouplingPlace coupling_place(const AssetView& asset, const ContactPoint& at) noexcept {
  CouplingPlace out;
  out.share = coupling_share(asset, *asset.coupling, at.triangle, at.weight);
  out.point = {0, 0, 0};
  for (int k = 0; k < 3; ++k)
    out.point = out.point + asset.vertex_at(asset.corner(at.triangle, k)) * at.weight[k];
  out.normal = blended_normal(asset, at.triangle, at.weight);
  if (asset.sways) out.root = root_of(compliance_at(asset, at.triangle, at.weight));
  return out;
}

/// C_ij (M62), (M62a) of two places, and C_ji, which is its transpose.
inline void couple(const AssetView& asset, const CouplingPlace& a, const CouplingPlace& b,
                   double ab[9], double ba[9]) noexcept {
  const Vec3d distance = a.point - b.point;
  const Coupling by = coupling_at(*asset.coupling, dot(distance, distance));
  const Vec3d axis[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (int c = 0; c < 3; ++c) {
    Vec3d column = coupled(by, a.normal, b.normal, axis[c]) * (a.share * b.share);
    if (asset.sways) column = column + a.root.times(b.root.back_times(axis[c]));
    const double rows[3] = {column.x, column.y, column.z};
    for (int r = 0; r < 3; ++r) ab[3 * r + c] = ba[3 * c + r] = rows[r];
  }
}

/// Displacement of the body under a ball or tip in the air at x by contacts that carry `force`: as
/// if it touched along the normal of each, and swayed as the nearest one does.
inline Vec3d displacement_beside(const AssetView& asset, const CouplingPlace* place,
                                 const Vec3d* force, int count, const Vec3d& x,
                                 double radius_m) noexcept {
  Vec3d sum{0, 0, 0}, pulled{0, 0, 0};
  int nearest = 0;
  double least = 1e300;
  for (int k = 0; k < count; ++k) {
    const Vec3d distance = x + place[k].normal * radius_m - place[k].point;
    const double squared = dot(distance, distance);
    sum = sum + coupled(coupling_at(*asset.coupling, squared), place[k].normal, place[k].normal,
                        force[k] * place[k].share);
    if (asset.sways) pulled = pulled + place[k].root.back_times(force[k]);
    if (squared < least) nearest = k;
    least = squared < least ? squared : least;
  }
  return asset.sways && count > 0 ? sum + place[nearest].root.times(pulled) : sum;
}

/// Force under which the slow displacement of the body equals the flow of its dashpots.
inline Vec3d rest_force(const RelaxationView& relaxation, const SeriesMemory& memory) noexcept {
  Vec3d sum{0, 0, 0};
  for (int k = 0; k < relaxation.branches; ++k)
    sum = sum + memory.flowed(k) * (relaxation.share[k] / relaxation.fast);
  return sum;
}
/// The same for where it is under a force now (M49a).
inline Vec3d slow_force(const RelaxationView& relaxation, const SeriesMemory& memory,
                        const Vec3d& force) noexcept {
  return rest_force(relaxation, memory) + force * (1 / relaxation.fast);
}
/// The dashpots flow over the whole of a tick while the body stays where it is under `slow`; left:
/// of half of its time.
inline void relax_compliance(const RelaxationView& relaxation, const Decay& left, const Vec3d& slow,
                             SeriesMemory& memory) noexcept {
  for (int k = 0; k < relaxation.branches; ++k) {
    const Vec3d lag = (slow - memory.flowed(k)) * (left.share[k] * left.share[k]);
    const auto is_over = [](double f) noexcept { return !(std::fabs(f) > kSettleZero_N * 1e-12); };
    put({slow.x - (is_over(lag.x) ? 0 : lag.x), slow.y - (is_over(lag.y) ? 0 : lag.y),
         slow.z - (is_over(lag.z) ? 0 : lag.z)},
        memory.flowed_N[k]);
  }
}

}  // namespace palpate::runtime
