// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// How a force on one place of a body moves another (docs/method-tools.md, section 28): a compliance
// that falls with the distance r between two contacts, and is positive definite over any places,
//
//     C_ij = s_i s_j (a(r) 1 + b(r) P_i P_j)    a(r) = sum_k a_k / (1 + r^2 / (2^k l)^2)^2  (M62)
//
// with P = 1 - u u^T at each of them, b likewise, and s the share that a stiff contact bears
// (coupling_share).

#include "../base/scalar.hpp"

namespace palpate {
namespace runtime {

constexpr int kCouplingScales = 6;
constexpr double kMaxCouplingLength_m = 1e3, kMaxCoupling_m_N = 1e6;
/// Most of a contact's own compliance that s^2 a(0) may be: below 1 the joint energy of any number
/// of tools stays convex.
constexpr double kMostCoupling = 0.8;

/// Of a body; length_m 0: tools do not feel each other.
struct CouplingView {
  double length_m = 0;                      ///< l
  double give_m_N[kCouplingScales] = {};    ///< a_k, none negative
  double across_m_N[kCouplingScales] = {};  ///< b_k, none negative

  bool is_any() const noexcept { return length_m > 0; }
};

/// One term of (M62), over its factor.
inline double coupling_term(double length_m, int scale, double squared_m2) noexcept {
  const double reach = length_m * double(1 << scale);
  const double x = 1 / (1 + squared_m2 / (reach * reach));
  return x * x;
}

/// a(r) and b(r) [m/N] (M62).
struct Coupling {
  double give = 0, across = 0;
};
inline Coupling coupling_at(const CouplingView& view, double squared_m2) noexcept {
  Coupling out;
  for (int k = 0; k < kCouplingScales; ++k) {
    const double term = coupling_term(view.length_m, k, squared_m2);
    out.give += view.give_m_N[k] * term;
    out.across += view.across_m_N[k] * term;
  }
  return out;
}

/// C_ij f (M62) of inward normals u_i and u_j.
inline Vec3d coupled(const Coupling& at, const Vec3d& u_i, const Vec3d& u_j,
                     const Vec3d& f) noexcept {
  const Vec3d along = f - u_j * dot(f, u_j);
  return f * at.give + (along - u_i * dot(along, u_i)) * at.across;
}

/// Whether the numbers are in range.
inline bool is_possible(const CouplingView& view) noexcept {
  if (!(view.length_m > 0 && view.length_m <= kMaxCouplingLength_m)) return false;
  for (int k = 0; k < kCouplingScales; ++k)
    if (!(view.give_m_N[k] >= 0 && view.give_m_N[k] <= kMaxCoupling_m_N &&
          view.across_m_N[k] >= 0 && view.across_m_N[k] <= kMaxCoupling_m_N))
      return false;
  return true;
}

/// a(0), or a(0) + b(0) across, over what it may be where a contact is as stiff as that along its
/// normal and across it [N/m].
inline double coupling_excess(const CouplingView& view, double normal_N_m,
                              double across_N_m) noexcept {
  const Coupling most = coupling_at(view, 0);
  const double along = most.give * normal_N_m, aside = (most.give + most.across) * across_N_m;
  return (along > aside ? along : aside) / kMostCoupling;
}

}  // namespace runtime
}  // namespace palpate
