// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The forces of contacts in series with the compliance under them (docs/method-tools.md, section
// 28): n contacts at x_i with laws R_i, and the compliance C_ij by which a force on contact j moves
// the body under contact i,
//
//     f_i = R_i(x_i - sum_j C_ij f_j)                                             (M34), (M63)
//
// One contact on a body that sways is n = 1.

#include <cmath>

#include "../asset/view.hpp"
#include "../law/compliance.hpp"
#include "../law/coupling.hpp"

namespace palpate::runtime {

inline Vec3d times(const double m[9], const Vec3d& v) noexcept {
  return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[3] * v.x + m[4] * v.y + m[5] * v.z,
          m[6] * v.x + m[7] * v.y + m[8] * v.z};
}

/// C_ij between the contacts of a tick [m/N], row-major blocks.
struct ComplianceMatrix {
  int count = 0;
  double block[kMaxContacts][kMaxContacts][9];

  /// sum_j C_ij f_j.
  Vec3d displacement(int i, const Vec3d* force) const noexcept {
    Vec3d sum{0, 0, 0};
    for (int j = 0; j < count; ++j) sum = sum + times(block[i][j], force[j]);
    return sum;
  }
  /// 1/2 sum_ij f_i C_ij f_j.
  double stored_J(const Vec3d* force) const noexcept {
    double sum = 0;
    for (int i = 0; i < count; ++i) sum += 0.5 * dot(force[i], displacement(i, force));
    return sum;
  }
};

/// 1 + K C of n contacts with stiffnesses K_i, factored: L U with row pivots, column by column, so
/// that compilers take several rows at once.
class SeriesMatrix {
 public:
  /// For so many contacts.
  bool is_made(int count) const noexcept { return size_ == 3 * count; }

  /// A singular matrix makes solve() the identity.
  void factor(const ComplianceMatrix& compliance, double share, const double* const* K) noexcept {
    size_ = 3 * compliance.count;
    for (int i = 0; i < compliance.count; ++i)
      for (int j = 0; j < compliance.count; ++j) {
        const double* C = compliance.block[i][j];
        for (int c = 0; c < 3; ++c) {
          const double x = C[c] * share, y = C[3 + c] * share, z = C[6 + c] * share;
          double* const to = column_[3 * j + c] + 3 * i;
          for (int r = 0; r < 3; ++r)
            to[r] = K[i][3 * r] * x + K[i][3 * r + 1] * y + K[i][3 * r + 2] * z;
          if (i == j) to[c] += 1;
        }
      }
    is_regular_ = true;
    for (int c = 0; c < size_ && is_regular_; ++c) is_regular_ = eliminate(c);
  }

  /// v becomes (1 + K C)^-1 v.
  void solve(Vec3d* v) const noexcept {
    if (!is_regular_) return;
    double b[3 * kMaxContacts];
    for (int i = 0; i < size_ / 3; ++i) put(v[i], b + 3 * i);
    for (int c = 0; c < size_; ++c) {
      const double kept = b[c];
      b[c] = b[pivot_[c]];
      b[pivot_[c]] = kept;
    }
    for (int c = 0; c < size_; ++c)
      for (int r = c + 1; r < size_; ++r) b[r] -= column_[c][r] * b[c];
    for (int c = size_ - 1; c >= 0; --c) {
      b[c] *= inverse_[c];
      for (int r = 0; r < c; ++r) b[r] -= column_[c][r] * b[c];
    }
    for (int i = 0; i < size_ / 3; ++i) v[i] = make_vec3<double>(b + 3 * i);
  }

 private:
  bool eliminate(int c) noexcept {
    double* const at = column_[c];
    int pivot = c;
    for (int r = c + 1; r < size_; ++r)
      if (std::fabs(at[r]) > std::fabs(at[pivot])) pivot = r;
    pivot_[c] = pivot;
    if (!(std::fabs(at[pivot]) > 1e-9)) return false;
    for (int k = 0; k < size_ && pivot != c; ++k) {
      const double kept = column_[k][c];
      column_[k][c] = column_[k][pivot];
      column_[k][pivot] = kept;
    }
    inverse_[c] = 1 / at[c];
    for (int r = c + 1; r < size_; ++r) at[r] *= inverse_[c];
    for (int k = c + 1; k < size_; ++k) {
      double* const to = column_[k];
      const double factor = to[c];
      for (int r = c + 1; r < size_; ++r) to[r] -= factor * at[r];
    }
    return true;
  }

  int size_ = 0;
  bool is_regular_ = false;
  int pivot_[3 * kMaxContacts];
  double inverse_[3 * kMaxContacts], column_[3 * kMaxContacts][3 * kMaxContacts];
};

/// The unknowns of one root.
struct SeriesForces {
  const ComplianceMatrix* compliance = nullptr;
  double share = 1;                  ///< of C that acts at once; the rest is in `rest`
  Vec3d rest[kMaxContacts];          ///< x_i less the flow: relative position under no force
  Vec3d force[kMaxContacts];         ///< begins as a guess
  Vec3d residual_N[kMaxContacts];    ///< force of law i minus force[i]
  Vec3d correction_N[kMaxContacts];  ///< last correction, of the order of off: the force without
                                     ///< error
  double* stiffness[kMaxContacts];   ///< of the laws there, row-major dR/dy; saves steps

  int count() const noexcept { return compliance->count; }
  /// Position of tool i relative to the displaced body: the argument of law i.
  Vec3d relative_position(int i) const noexcept {
    return rest[i] - compliance->displacement(i, force) * share;
  }
};

/// Corrects a stiffness by the change of force over a move (Broyden 1965,
/// doi:10.1090/S0025-5718-1965-0198670-6). aside: how far the body has moved there.
inline void correct_stiffness(double K[9], const Vec3d& moved, const Vec3d& answered,
                              const Vec3d& aside) noexcept {
  const Vec3d residual_N = answered - times(K, moved);
  const double squared = dot(moved, moved);
  if (!(squared > kMinSecantMove * kMinSecantMove * dot(aside, aside)) || !is_finite(residual_N))
    return;
  const Vec3d direction = moved * (1 / squared);
  const double w[3] = {direction.x, direction.y, direction.z},
               o[3] = {residual_N.x, residual_N.y, residual_N.z};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) K[3 * r + c] += o[r] * w[c];
}

/// A root that is being looked for.
template <class Respond>
class RootSearch {
 public:
  RootSearch(SeriesForces& s, SeriesMatrix& matrix, double tolerance,
             const Respond& respond) noexcept
      : s_(s), n_(s.count()), matrix_(matrix), tolerance_(tolerance), respond_(respond) {}

  /// Newton's step from forces of the laws at relative positions `before`.
  void predict(const Vec3d* before) noexcept {
    Vec3d step[kMaxContacts];
    for (int i = 0; i < n_; ++i)
      step[i] = times(s_.stiffness[i], s_.relative_position(i) - before[i]);
    solve(step);
    for (int i = 0; i < n_; ++i) s_.force[i] = s_.force[i] + step[i];
  }
  bool run() noexcept {
    evaluate(at_);
    bool is_last = true;
    for (int k = 0; k < kMaxSettleSteps && !is_root() && at_.error < 1e300; ++k) {
      Vec3d step[kMaxContacts], before[kMaxContacts];
      for (int i = 0; i < n_; ++i) step[i] = at_.residual_N[i];
      solve(step);
      for (int i = 0; i < n_; ++i) {
        before[i] = s_.force[i];
        s_.force[i] = s_.force[i] + step[i];
      }
      Evaluation next;
      evaluate(next);
      for (int i = 0; i < n_; ++i)
        correct_stiffness(s_.stiffness[i], next.place[i] - at_.place[i],
                          next.answer[i] - at_.answer[i], s_.rest[i] - next.place[i]);
      is_last = next.error < at_.error;
      if (!(next.error < kMaxErrorRatio * kMaxErrorRatio * at_.error)) make_matrix();
      if (is_last)
        at_ = next;
      else
        for (int i = 0; i < n_; ++i) s_.force[i] = before[i];
    }
    if (!is_last)
      for (int i = 0; i < n_; ++i) respond_(i, at_.place[i]);
    end();
    return is_root();
  }

 private:
  struct Evaluation {
    Vec3d place[kMaxContacts], answer[kMaxContacts], residual_N[kMaxContacts];
    double error = 0, size = 0;  ///< squared
  };
  void evaluate(Evaluation& out) noexcept {
    for (int i = 0; i < n_; ++i) {
      out.place[i] = s_.relative_position(i);
      out.answer[i] = respond_(i, out.place[i]);
      out.residual_N[i] = out.answer[i] - s_.force[i];
      out.error += dot(out.residual_N[i], out.residual_N[i]);
      out.size += dot(out.answer[i], out.answer[i]);
    }
  }
  bool is_root() const noexcept {
    return at_.error <= tolerance_ * tolerance_ * at_.size + kSettleZero_N * kSettleZero_N;
  }
  void make_matrix() noexcept {
    const double* K[kMaxContacts] = {};
    for (int i = 0; i < n_; ++i) K[i] = s_.stiffness[i];
    matrix_.factor(*s_.compliance, s_.share, K);
  }
  void solve(Vec3d* v) noexcept {
    if (!matrix_.is_made(n_)) make_matrix();
    matrix_.solve(v);
  }
  void end() noexcept {
    const bool found = is_root();
    for (int i = 0; i < n_; ++i) {
      s_.residual_N[i] = s_.correction_N[i] = at_.residual_N[i];
      for (int c = 0; c < 9 && !found; ++c) s_.stiffness[i][c] = 0;  // it leads nowhere
    }
    if (found && matrix_.is_made(n_)) matrix_.solve(s_.correction_N);
  }

  SeriesForces& s_;
  int n_;
  SeriesMatrix& matrix_;
  double tolerance_;
  const Respond& respond_;
  Evaluation at_;
};

/// Brings the forces to the root of (M63), by Newton's steps with stiffnesses that each answer
/// corrects. matrix: of an earlier root near this one, or a fresh one; it is made where it is
/// needed and where steps are slow. before: the relative positions at which the laws gave the
/// guess; null where that is as good as can be had. respond(i, y): the force of law i for a tool at
/// y; its last calls are with the forces that are kept. false: kMaxSettleSteps were not enough, and
/// the nearest forces are kept.
template <class Respond>
bool settle(SeriesForces& s, SeriesMatrix& matrix, const Vec3d* before, const Respond& respond,
            double tolerance = kSettleTolerance) noexcept {
  RootSearch<Respond> search(s, matrix, tolerance, respond);
  if (before != nullptr) search.predict(before);
  return search.run();
}

}  // namespace palpate::runtime
