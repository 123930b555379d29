// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// A body that gives as a whole under the tool (docs/method.md, section 21): a compliance C in
// series with the contact's law. The surface around the contact moves by C f, so the law answers
// the tool at x - C f, and the force is the root of
//
//     f = R(x - C f)                                                                    (M34)
//
// One template for the engine and for the fitter's replay.

#include "families/relaxation.hpp"
#include "scalar.hpp"

namespace palpate {
namespace runtime {

constexpr int kMaxSwaySteps = 16;  ///< answers of the law for one force; 5.6 on the scanned liver
constexpr double kSwayTolerance = 1e-9;  ///< of the force: stored energy is then right to 1e-18
constexpr double kSwayZero_N = 1e-12;    ///< below it a force is noise

/// C [m/N], symmetric and nowhere negative: xx, yy, zz, xy, xz, yz.
struct Compliance {
  double c[6] = {0, 0, 0, 0, 0, 0};

  Vec3d times(const Vec3d& f) const noexcept {
    return {c[0] * f.x + c[3] * f.y + c[4] * f.z, c[3] * f.x + c[1] * f.y + c[5] * f.z,
            c[4] * f.x + c[5] * f.y + c[2] * f.z};
  }
  bool is_any() const noexcept {
    for (double x : c)
      if (x != 0) return true;
    return false;
  }
  Compliance over(double share) const noexcept {
    Compliance out;
    for (int i = 0; i < 6; ++i) out.c[i] = c[i] / share;
    return out;
  }
  /// What the sway stores under a force.
  double stored_J(const Vec3d& f) const noexcept { return 0.5 * dot(f, times(f)); }
};

/// L with L L^T = C: lower triangular, xx, yx, yy, zx, zy, zz [sqrt(m/N)]; a direction that does
/// not give has none.
struct ComplianceRoot {
  double l[6] = {0, 0, 0, 0, 0, 0};

  Vec3d times(const Vec3d& v) const noexcept {
    return {l[0] * v.x, l[1] * v.x + l[2] * v.y, l[3] * v.x + l[4] * v.y + l[5] * v.z};
  }
  Vec3d back_times(const Vec3d& v) const noexcept {
    return {l[0] * v.x + l[1] * v.y + l[3] * v.z, l[2] * v.y + l[4] * v.z, l[5] * v.z};
  }
};
/// Cholesky's factor.
inline ComplianceRoot root_of(const Compliance& give) noexcept {
  const double* c = give.c;
  const double least = 1e-12 * (c[0] + c[1] + c[2]);
  ComplianceRoot out;
  double* l = out.l;
  if (c[0] > least) {
    l[0] = std::sqrt(c[0]);
    l[1] = c[3] / l[0];
    l[3] = c[4] / l[0];
  }
  const double yy = c[1] - l[1] * l[1];
  if (yy > least) {
    l[2] = std::sqrt(yy);
    l[4] = (c[5] - l[3] * l[1]) / l[2];
  }
  const double zz = c[2] - l[3] * l[3] - l[4] * l[4];
  if (zz > least) l[5] = std::sqrt(zz);
  return out;
}

/// Whether no force is given way to backwards, but for rounding to float.
inline bool is_nowhere_negative(const double c[6]) noexcept {
  const double most = c[0] + c[1] + c[2], slack = 1e-6 * most;
  const double x = c[0] + slack, y = c[1] + slack, z = c[2] + slack;
  const double xy = x * y - c[3] * c[3], xz = x * z - c[4] * c[4], yz = y * z - c[5] * c[5];
  const double all = x * yz - c[3] * (c[3] * z - c[5] * c[4]) + c[4] * (c[3] * c[5] - y * c[4]);
  return x >= 0 && y >= 0 && z >= 0 && xy >= 0 && xz >= 0 && yz >= 0 && all >= 0;
}

/// The law's force on the body at the last tick, which is that in the series, and how stiff the law
/// was around it: what a contact remembers.
struct Sway {
  double force_N[3] = {0, 0, 0};
  double stiffness_N_m[9] = {0, 0, 0, 0, 0, 0, 0, 0, 0};  ///< saves steps; row-major, dR/dy
  double flowed_N[kMaxBranches][3] = {};                  ///< w_k (M49a) of a body that relaxes

  Vec3d force() const noexcept { return make_vec3<double>(force_N); }
  Vec3d flowed(int branch) const noexcept { return make_vec3<double>(flowed_N[branch]); }
};

/// Force under which the body has swayed as far in slow motion as its dashpots have flowed.
inline Vec3d rest_force(const RelaxationView& relaxation, const Sway& sway) noexcept {
  Vec3d sum{0, 0, 0};
  for (int k = 0; k < relaxation.branches; ++k)
    sum = sum + sway.flowed(k) * (relaxation.share[k] / relaxation.fast);
  return sum;
}
/// The same for where it is under a force now: the sway is C times it (M49a).
inline Vec3d slow_force(const RelaxationView& relaxation, const Sway& sway,
                        const Vec3d& force) noexcept {
  return rest_force(relaxation, sway) + force * (1 / relaxation.fast);
}
/// What the sway stores under a force (M49a).
inline double sway_energy(const RelaxationView& relaxation, const Sway& sway,
                          const Compliance& give, const Vec3d& force) noexcept {
  const Vec3d slow = slow_force(relaxation, sway, force);
  double sum = give.stored_J(slow);
  for (int k = 0; k < relaxation.branches; ++k)
    sum += relaxation.share[k] * give.stored_J(slow - sway.flowed(k));
  return sum;
}
/// The dashpots flow while the sway stays where it is; left: of half of the time.
inline void let_creep(const RelaxationView& relaxation, const Decay& left, Sway& sway) noexcept {
  const Vec3d slow = slow_force(relaxation, sway, sway.force());
  for (int k = 0; k < relaxation.branches; ++k)
    put(slow - (slow - sway.flowed(k)) * (left.share[k] * left.share[k]), sway.flowed_N[k]);
}

inline Vec3d times(const double m[9], const Vec3d& v) noexcept {
  return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[3] * v.x + m[4] * v.y + m[5] * v.z,
          m[6] * v.x + m[7] * v.y + m[8] * v.z};
}
/// (1 + K C)^-1 v; v itself where there is no such matrix.
inline Vec3d unload(const double stiffness_N_m[9], const Compliance& give,
                    const Vec3d& v) noexcept {
  const Vec3d row[3] = {{give.c[0], give.c[3], give.c[4]},
                        {give.c[3], give.c[1], give.c[5]},
                        {give.c[4], give.c[5], give.c[2]}};
  const Vec3d a = times(stiffness_N_m, row[0]) + Vec3d{1, 0, 0},  // columns, C is symmetric
      b = times(stiffness_N_m, row[1]) + Vec3d{0, 1, 0},
              c = times(stiffness_N_m, row[2]) + Vec3d{0, 0, 1};
  const Vec3d bc = cross(b, c);
  const double determinant = dot(a, bc);
  if (!(std::fabs(determinant) > 1e-6)) return v;
  return Vec3d{dot(v, bc), dot(a, cross(v, c)), dot(a, cross(b, v))} * (1 / determinant);
}

/// Brings sway.force_N to the root of (M34) by Broyden's method (1965,
/// doi:10.1090/S0025-5718-1965-0198670-6), from the force that it has. respond(f): the law's answer
/// R(x - C f) [N]; its last call is with the force that is kept. false: kMaxSwaySteps were not
/// enough, and the nearest force is kept.
template <class Respond>
bool settle(const Compliance& give, Sway& sway, const Respond& respond) noexcept {
  Vec3d force = make_vec3<double>(sway.force_N), answer = respond(force), rest = answer - force;
  double* K = sway.stiffness_N_m;
  bool is_root = false;
  for (int i = 0; i < kMaxSwaySteps; ++i) {
    const double error = dot(rest, rest), size = dot(answer, answer);
    is_root = error <= kSwayTolerance * kSwayTolerance * size + kSwayZero_N * kSwayZero_N;
    if (is_root || !is_finite(rest)) break;
    const Vec3d step = unload(K, give, rest), next = force + step, moved = give.times(step) * -1.0;
    const Vec3d next_answer = respond(next), next_rest = next_answer - next;
    const Vec3d off = next_answer - answer - times(K, moved);
    const double squared = dot(moved, moved);
    if (squared > 0 && is_finite(off)) {
      const Vec3d way = moved * (1 / squared);
      const double w[3] = {way.x, way.y, way.z}, o[3] = {off.x, off.y, off.z};
      for (int r = 0; r < 3; ++r)
        for (int k = 0; k < 3; ++k) K[3 * r + k] += o[r] * w[k];
    }
    if (!(dot(next_rest, next_rest) < error)) continue;
    force = next;
    answer = next_answer;
    rest = next_rest;
  }
  if (!is_root) respond(force);
  sway.force_N[0] = force.x;
  sway.force_N[1] = force.y;
  sway.force_N[2] = force.z;
  return is_root;
}

}  // namespace runtime
}  // namespace palpate
