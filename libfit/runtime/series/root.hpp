// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The forces of contacts in series with what gives under them (docs/method.md, section 28): n
// contacts at x_i whose laws answer R_i, and the compliance C_ij by which a force on contact j
// moves the body under contact i,
//
//     f_i = R_i(x_i - sum_j C_ij f_j)                                             (M34), (M63)
//
// One contact on a body that sways is n = 1.

#include <cmath>

#include "../asset/view.hpp"
#include "../law/compliance.hpp"
#include "../law/coupling.hpp"

namespace palpate {
namespace runtime {

constexpr int kMaxContacts = 8;
constexpr int kMaxSettleSteps = 16;      ///< answers of each law for one root; 2 to 4 as a rule
constexpr double kSettleTolerance = 1e-7;  ///< of the forces, before the last correction
constexpr double kSettleZero_N = 1e-12;    ///< below it a force is noise
constexpr double kSettleFall = 0.1;  ///< a step that leaves more of the error has a new matrix made

inline Vec3d times(const double m[9], const Vec3d& v) noexcept {
  return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[3] * v.x + m[4] * v.y + m[5] * v.z,
          m[6] * v.x + m[7] * v.y + m[8] * v.z};
}

/// C_ij between the contacts of a tick [m/N], row-major blocks.
struct GiveBetween {
  int count = 0;
  double block[kMaxContacts][kMaxContacts][9];

  /// sum_j C_ij f_j.
  Vec3d sunk(int i, const Vec3d* force) const noexcept {
    Vec3d sum{0, 0, 0};
    for (int j = 0; j < count; ++j) sum = sum + times(block[i][j], force[j]);
    return sum;
  }
  /// 1/2 sum_ij f_i C_ij f_j.
  double stored_J(const Vec3d* force) const noexcept {
    double sum = 0;
    for (int i = 0; i < count; ++i) sum += 0.5 * dot(force[i], sunk(i, force));
    return sum;
  }
};

/// 1 + K C of n contacts with stiffnesses K_i, factored: L U with row pivots.
class SeriesMatrix {
 public:
  /// False where it has no inverse; solve() then is the identity.
  bool factor(const GiveBetween& give, double share, const double* const* K) noexcept {
    size_ = 3 * give.count;
    for (int i = 0; i < give.count; ++i)
      for (int j = 0; j < give.count; ++j) {
        const double* C = give.block[i][j];
        for (int r = 0; r < 3; ++r) {
          const double a = K[i][3 * r] * share, b = K[i][3 * r + 1] * share,
                       c = K[i][3 * r + 2] * share;
          for (int k = 0; k < 3; ++k)
            m_[3 * i + r][3 * j + k] = a * C[k] + b * C[3 + k] + c * C[6 + k];
          if (i == j) m_[3 * i + r][3 * j + r] += 1;
        }
      }
    is_regular_ = true;
    for (int c = 0; c < size_ && is_regular_; ++c) is_regular_ = eliminate(c);
    return is_regular_;
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
    for (int r = 1; r < size_; ++r)
      for (int k = 0; k < r; ++k) b[r] -= m_[r][k] * b[k];
    for (int r = size_ - 1; r >= 0; --r) {
      for (int k = r + 1; k < size_; ++k) b[r] -= m_[r][k] * b[k];
      b[r] *= inverse_[r];
    }
    for (int i = 0; i < size_ / 3; ++i) v[i] = make_vec3<double>(b + 3 * i);
  }

 private:
  bool eliminate(int c) noexcept {
    int pivot = c;
    for (int r = c + 1; r < size_; ++r)
      if (std::fabs(m_[r][c]) > std::fabs(m_[pivot][c])) pivot = r;
    pivot_[c] = pivot;
    if (!(std::fabs(m_[pivot][c]) > 1e-9)) return false;
    for (int k = 0; k < size_ && pivot != c; ++k) {
      const double kept = m_[c][k];
      m_[c][k] = m_[pivot][k];
      m_[pivot][k] = kept;
    }
    inverse_[c] = 1 / m_[c][c];
    for (int r = c + 1; r < size_; ++r) {
      const double factor = m_[r][c] *= inverse_[c];
      if (factor == 0) continue;
      for (int k = c + 1; k < size_; ++k) m_[r][k] -= factor * m_[c][k];
    }
    return true;
  }

  int size_ = 0;
  bool is_regular_ = false;
  int pivot_[3 * kMaxContacts];
  double inverse_[3 * kMaxContacts], m_[3 * kMaxContacts][3 * kMaxContacts];
};

/// The unknowns of one root.
struct SeriesForces {
  const GiveBetween* give = nullptr;
  double share = 1;               ///< of C that gives at once; the rest is in `rest`
  Vec3d rest[kMaxContacts];       ///< x_i less what has flowed: where law i sees no force
  Vec3d force[kMaxContacts];      ///< begins as a guess
  Vec3d off[kMaxContacts];        ///< what the laws answer more than that
  Vec3d more[kMaxContacts];       ///< last correction, of the order of off: the force without error
  double* stiffness[kMaxContacts];  ///< of the laws there, row-major dR/dy; saves steps

  int count() const noexcept { return give->count; }
  /// Where law i sees its tool.
  Vec3d seen(int i) const noexcept { return rest[i] - give->sunk(i, force) * share; }
};

/// Shorter moves than this share of how far the body has moved say nothing of a stiffness: a slip is
/// solved to 1e-10 of its limit.
constexpr double kTellingMove = 1e-7;

/// Corrects a stiffness by what the law answered to a move (Broyden 1965,
/// doi:10.1090/S0025-5718-1965-0198670-6). aside: how far the body has moved there.
inline void correct_stiffness(double K[9], const Vec3d& moved, const Vec3d& answered,
                              const Vec3d& aside) noexcept {
  const Vec3d off = answered - times(K, moved);
  const double squared = dot(moved, moved);
  if (!(squared > kTellingMove * kTellingMove * dot(aside, aside)) || !is_finite(off)) return;
  const Vec3d way = moved * (1 / squared);
  const double w[3] = {way.x, way.y, way.z}, o[3] = {off.x, off.y, off.z};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) K[3 * r + c] += o[r] * w[c];
}

/// Brings the forces to the root of (M63), by Newton's steps with stiffnesses that each answer
/// corrects. before: where each law saw its tool when it answered the guess. respond(i, y): the
/// answer of law i to a tool at y; its last calls are with the forces that are kept. false:
/// kMaxSettleSteps were not enough, and the nearest forces are kept.
template <class Respond>
bool settle(SeriesForces& s, const Vec3d* before, const Respond& respond) noexcept {
  const int n = s.count();
  SeriesMatrix matrix;
  const double* K[kMaxContacts];
  for (int i = 0; i < n; ++i) K[i] = s.stiffness[i];
  matrix.factor(*s.give, s.share, K);
  Vec3d place[kMaxContacts], answer[kMaxContacts], rest[kMaxContacts], step[kMaxContacts],
      next[kMaxContacts];
  for (int i = 0; i < n; ++i) step[i] = times(K[i], s.seen(i) - before[i]);
  matrix.solve(step);
  for (int i = 0; i < n; ++i) s.force[i] = s.force[i] + step[i];
  double error = 0, size = 0;
  for (int i = 0; i < n; ++i) {
    place[i] = s.seen(i);
    answer[i] = respond(i, place[i]);
    rest[i] = answer[i] - s.force[i];
    error += dot(rest[i], rest[i]);
    size += dot(answer[i], answer[i]);
  }
  bool is_root = false, is_last = true;
  for (int k = 0;; ++k) {
    is_root = error <= kSettleTolerance * kSettleTolerance * size + kSettleZero_N * kSettleZero_N;
    if (is_root || k == kMaxSettleSteps || !(error < 1e300)) break;
    for (int i = 0; i < n; ++i) step[i] = rest[i];
    matrix.solve(step);
    double next_error = 0, next_size = 0;
    for (int i = 0; i < n; ++i) {
      next[i] = s.force[i];
      s.force[i] = s.force[i] + step[i];
    }
    Vec3d next_place[kMaxContacts], next_answer[kMaxContacts];
    for (int i = 0; i < n; ++i) {
      next_place[i] = s.seen(i);
      next_answer[i] = respond(i, next_place[i]);
      const Vec3d left = next_answer[i] - s.force[i];
      next_error += dot(left, left);
      next_size += dot(next_answer[i], next_answer[i]);
      correct_stiffness(s.stiffness[i], next_place[i] - place[i], next_answer[i] - answer[i],
                        s.rest[i] - next_place[i]);
    }
    is_last = next_error < error;
    const bool is_slow = !(next_error < kSettleFall * kSettleFall * error);
    for (int i = 0; i < n; ++i) {
      if (!is_last) {
        s.force[i] = next[i];
        continue;
      }
      place[i] = next_place[i];
      answer[i] = next_answer[i];
      rest[i] = answer[i] - s.force[i];
    }
    if (is_last) {
      error = next_error;
      size = next_size;
    }
    if (is_slow) matrix.factor(*s.give, s.share, K);
  }
  if (!is_last)
    for (int i = 0; i < n; ++i) respond(i, place[i]);
  for (int i = 0; i < n; ++i) {
    s.off[i] = s.more[i] = rest[i];
    for (int c = 0; c < 9 && !is_root; ++c) s.stiffness[i][c] = 0;  // it leads nowhere
  }
  if (is_root) matrix.solve(s.more);
  return is_root;
}

}  // namespace runtime
}  // namespace palpate
