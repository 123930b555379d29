// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// Displacement of one place of a body by a force on another (docs/method-tools.md, section 28): a
// compliance that falls with the distance r between two contacts, and is positive definite over any
// places,
//
//     C_ij = s_i s_j (a(r) 1 + b(r) P_i P_j)    a(r) = sum_k a_k / (1 + r^2 / (2^k l)^2)^2  (M62)
//
// with P = 1 - u u^T at each of them, b likewise, and s the share that a stiff contact has
// (coupling_share).

#include "../base/constants.hpp"
#include "../base/scalar.hpp"

namespace palpate::runtime {

constexpr int kCouplingScales = 6;

/// Constants of a body; length_m 0: contacts do not move each other.
struct CouplingView {
  double length_m = 0;                          ///< l
  double isotropic_m_N[kCouplingScales] = {};   ///< a_k, none negative
  double tangential_m_N[kCouplingScales] = {};  ///< b_k, none negative

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
  double isotropic = 0, tangential = 0;
};
inline Coupling coupling_at(const CouplingView& view, double squared_m2) noexcept {
  Coupling out;
  for (int k = 0; k < kCouplingScales; ++k) {
    const double term = coupling_term(view.length_m, k, squared_m2);
    out.isotropic += view.isotropic_m_N[k] * term;
    out.tangential += view.tangential_m_N[k] * term;
  }
  return out;
}

/// C_ij f (M62) of inward normals u_i and u_j.
inline Vec3d coupled(const Coupling& at, const Vec3d& u_i, const Vec3d& u_j,
                     const Vec3d& f) noexcept {
  const Vec3d along = f - u_j * dot(f, u_j);
  return f * at.isotropic + (along - u_i * dot(along, u_i)) * at.tangential;
}

/// Returns true if the numbers are in range.
inline bool is_possible(const CouplingView& view) noexcept {
  if (!(view.length_m > 0 && view.length_m <= kMaxLength_m)) return false;
  for (int k = 0; k < kCouplingScales; ++k)
    if (!(view.isotropic_m_N[k] >= 0 && view.isotropic_m_N[k] <= kMaxCoupling_m_N &&
          view.tangential_m_N[k] >= 0 && view.tangential_m_N[k] <= kMaxCoupling_m_N))
      return false;
  return true;
}

/// a(0), or a(0) + b(0) across, over what it may be where a contact is as stiff as that along its
/// normal and across it [N/m].
inline double coupling_excess(const CouplingView& view, double normal_N_m,
                              double across_N_m) noexcept {
  const Coupling most = coupling_at(view, 0);
  const double along = most.isotropic * normal_N_m,
               aside = (most.isotropic + most.tangential) * across_N_m;
  return (along > aside ? along : aside) / kMaxCouplingShare;
}

}  // namespace palpate::runtime
