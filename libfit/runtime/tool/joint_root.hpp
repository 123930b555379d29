// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The forces of contacts that feel each other: the root of (M63), by Newton's steps.

#include <cmath>

#include "../asset/view.hpp"
#include "../families/coupling.hpp"
#include "../scalar.hpp"
#include "../sway.hpp"

namespace palpate {
namespace runtime {

constexpr int kMaxTools = 8;
constexpr int kMaxJointSteps = 16;        ///< answers of each law for one root; 3 to 5 as a rule
constexpr double kJointTolerance = 1e-7;  ///< of the forces; stored energy is then right to 1e-14

/// Solves m x = b of n unknowns by elimination with pivots, into b; false where there is none.
inline bool eliminate(double m[3 * kMaxTools][3 * kMaxTools], double b[3 * kMaxTools],
                      int n) noexcept {
  for (int c = 0; c < n; ++c) {
    int pivot = c;
    for (int r = c + 1; r < n; ++r)
      if (std::fabs(m[r][c]) > std::fabs(m[pivot][c])) pivot = r;
    if (!(std::fabs(m[pivot][c]) > 1e-9)) return false;
    for (int k = c; k < n && pivot != c; ++k) {
      const double kept = m[c][k];
      m[c][k] = m[pivot][k];
      m[pivot][k] = kept;
    }
    const double kept = b[c];
    b[c] = b[pivot];
    b[pivot] = kept;
    for (int r = c + 1; r < n; ++r) {
      const double factor = m[r][c] / m[c][c];
      if (factor == 0) continue;
      for (int k = c; k < n; ++k) m[r][k] -= factor * m[c][k];
      b[r] -= factor * b[c];
    }
  }
  for (int r = n - 1; r >= 0; --r) {
    for (int k = r + 1; k < n; ++k) b[r] -= m[r][k] * b[k];
    b[r] /= m[r][r];
  }
  return true;
}

/// The contacts of a tick that couple: where they are, and how each moves the others.
struct JointContacts {
  int count = 0;
  int tool[kMaxTools];
  Vec3d x[kMaxTools];                    ///< of the tools, from the asset's origin
  Vec3d point[kMaxTools];                ///< contact points
  Vec3d normal[kMaxTools];               ///< inward there
  double give[kMaxTools][kMaxTools][9];  ///< C_ij (M62), (M62a), row-major
  ComplianceRoot root[kMaxTools];        ///< of the sway at each
  bool sways = false;
  Vec3d force[kMaxTools];
  double* stiffness_N_m[kMaxTools];

  /// How far the forces have moved the surface at contact i [m].
  Vec3d sunk(int i, const Vec3d* forces) const noexcept {
    Vec3d sum{0, 0, 0};
    for (int j = 0; j < count; ++j)
      if (j != i || sways) sum = sum + times(give[i][j], forces[j]);
    return sum;
  }
  /// The same of a tool in the air at x: as if it touched along the normal of each contact, and
  /// swayed as the nearest one does.
  Vec3d sunk_beside(const AssetView& asset, const Vec3d& at_m, double radius_m) const noexcept {
    Vec3d sum{0, 0, 0}, pulled{0, 0, 0};
    int nearest = 0;
    double least = 1e300;
    for (int k = 0; k < count; ++k) {
      const Vec3d way = at_m + normal[k] * radius_m - point[k];
      const double squared = dot(way, way);
      sum = sum + coupled(coupling_at(*asset.coupling, squared), normal[k], normal[k], force[k]);
      if (sways) pulled = pulled + root[k].back_times(force[k]);
      if (squared < least) nearest = k;
      least = squared < least ? squared : least;
    }
    return sways && count > 0 ? sum + root[nearest].times(pulled) : sum;
  }
  /// What the coupling stores under the forces.
  double coupling_J() const noexcept {
    double sum = 0;
    for (int i = 0; i < count; ++i) sum += 0.5 * dot(force[i], sunk(i, force));
    return sum;
  }
  /// sway: of each contact, where the body does.
  void couple(const AssetView& asset, const Compliance* sway) noexcept {
    sways = asset.sways;
    const Vec3d axis[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int i = 0; i < count; ++i) {
      if (sways) root[i] = root_of(sway[i]);
      for (int j = 0; j <= i; ++j) {
        const Vec3d way = point[i] - point[j];
        const Coupling by = coupling_at(*asset.coupling, dot(way, way));
        for (int c = 0; c < 3; ++c) {
          Vec3d column{0, 0, 0};
          if (j != i) column = coupled(by, normal[i], normal[j], axis[c]);
          if (sways) column = column + root[i].times(root[j].back_times(axis[c]));
          const double rows[3] = {column.x, column.y, column.z};
          for (int r = 0; r < 3; ++r) give[i][j][3 * r + c] = give[j][i][3 * c + r] = rows[r];
        }
      }
    }
  }
};

/// Newton's step of (M63) from what is left of it: (1 + K C) step = rest.
inline void joint_step(const JointContacts& all, const Vec3d* rest, Vec3d* step) noexcept {
  double m[3 * kMaxTools][3 * kMaxTools], b[3 * kMaxTools];
  for (int i = 0; i < all.count; ++i) {
    put(rest[i], b + 3 * i);
    const double* K = all.stiffness_N_m[i];
    for (int j = 0; j < all.count; ++j) {
      const double* C = all.give[i][j];
      const bool couples = i != j || all.sways;
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c)
          m[3 * i + r][3 * j + c] =
              (i == j && r == c ? 1.0 : 0.0) +
              (couples ? K[3 * r] * C[c] + K[3 * r + 1] * C[3 + c] + K[3 * r + 2] * C[6 + c] : 0.0);
    }
  }
  const bool is_solved = eliminate(m, b, 3 * all.count);
  for (int i = 0; i < all.count; ++i) step[i] = is_solved ? make_vec3<double>(b + 3 * i) : rest[i];
}

/// Brings all.force to the root of (M63), from what it is, by Newton's steps with stiffnesses that
/// each answer corrects (Broyden 1965). respond(i, y): the answer of contact i to a tool at y; its
/// last calls are with the forces that are kept. false: kMaxJointSteps were not enough, and the
/// nearest forces are kept.
template <class Respond>
bool settle_jointly(JointContacts& all, const Respond& respond) noexcept {
  const int n = all.count;
  if (n == 1 && !all.sways) {
    all.force[0] = respond(0, all.x[0]);
    return true;
  }
  Vec3d place[kMaxTools], answer[kMaxTools], rest[kMaxTools], step[kMaxTools], next[kMaxTools];
  for (int i = 0; i < n; ++i) {
    place[i] = all.x[i] - all.sunk(i, all.force);
    answer[i] = respond(i, place[i]);
    rest[i] = answer[i] - all.force[i];
  }
  bool is_root = false, is_last = true;
  for (int k = 0; k < kMaxJointSteps; ++k) {
    double error = 0, size = 0;
    for (int i = 0; i < n; ++i) {
      error += dot(rest[i], rest[i]);
      size += dot(answer[i], answer[i]);
    }
    is_root = error <= kJointTolerance * kJointTolerance * size + kSwayZero_N * kSwayZero_N;
    if (is_root || !(error < 1e300)) break;
    joint_step(all, rest, step);
    for (int i = 0; i < n; ++i) next[i] = all.force[i] + step[i];
    double next_error = 0;
    Vec3d next_place[kMaxTools], next_answer[kMaxTools];
    for (int i = 0; i < n; ++i) {
      next_place[i] = all.x[i] - all.sunk(i, next);
      next_answer[i] = respond(i, next_place[i]);
      const Vec3d left = next_answer[i] - next[i];
      next_error += dot(left, left);
      const Vec3d moved = next_place[i] - place[i];
      double* K = all.stiffness_N_m[i];
      const Vec3d off = next_answer[i] - answer[i] - times(K, moved);
      const double squared = dot(moved, moved);
      if (!(squared > 0) || !is_finite(off)) continue;
      const Vec3d way = moved * (1 / squared);
      const double w[3] = {way.x, way.y, way.z}, o[3] = {off.x, off.y, off.z};
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) K[3 * r + c] += o[r] * w[c];
    }
    is_last = next_error < error;
    if (!is_last) continue;
    for (int i = 0; i < n; ++i) {
      all.force[i] = next[i];
      place[i] = next_place[i];
      answer[i] = next_answer[i];
      rest[i] = answer[i] - next[i];
    }
  }
  if (!is_last)
    for (int i = 0; i < n; ++i) respond(i, place[i]);
  return is_root;
}

}  // namespace runtime
}  // namespace palpate
