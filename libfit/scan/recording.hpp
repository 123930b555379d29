#pragma once

#include "libfit/core/curves.hpp"

namespace palpate::scan {

/// Places of the unknowns of a recording and of the whole body in `Recording::number`.
enum Shared : int {
  kDelay,
  kBias,
  kTurn = kBias + 3,
  kDrift = kTurn + 3,
  kCompliance = kDrift + 3,
  kLambda,
  kShare,
  kTime,
  kShared
};

/// `count` unknowns from `first` on, which are free together. The first is stated, or of three all:
/// `unit` times the number, or of a logarithm times its exponential.
struct SharedUnknown {
  const char *name, *symbol;
  int first, count;
  double unit;
  bool is_logarithm, needs_replay;
  double min, start;  ///< of the first
};
/// In the order in which they are tried: those without a replay are free from the start, and are
/// tried without. A force earlier than its motion would do work.
inline constexpr SharedUnknown kSharedUnknowns[] = {
    {"bias of the force", "N", kBias, 3, 1, false, false, -kInfinity, 0},
    {"turn of the force's frame", "rad", kTurn, 3, 1, false, false, -kInfinity, 0},
    {"drift of the force", "N/min", kDrift, 3, 1, false, false, -kInfinity, 0},
    {"delay of the force", "s", kDelay, 1, 0.01, false, true, 0, 0},
    {"lambda", "", kLambda, 1, 2.0 / 3, true, true, -kInfinity, 0},
    {"share of a relaxation", "", kShare, 2, 1, false, true, 0, 0.02},
    {"compliance of the arm", "mm/N", kCompliance, 1, 1, false, true, 0, 0}};

/// A recording and the body as a whole: numbers of order 1, 0 where nothing is known.
struct Recording {
  Eigen::Vector<double, kShared> number = Eigen::Vector<double, kShared>::Zero();

  double delay_s() const { return 0.01 * number[kDelay]; }  ///< the force is this late
  double compliance_m_N() const { return 1e-3 * number[kCompliance]; }
  double lambda() const;               ///< lateral over normal stiffness of a ring
  Relaxation relaxation() const;       ///< of at most one branch
  Mat3 turn() const;                   ///< from the frame of positions to that of forces
  Vec3 offset_N(double time_s) const;  ///< bias and drift
};

}  // namespace palpate::scan
