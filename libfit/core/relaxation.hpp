#pragma once

#include <Eigen/Core>

namespace palpate {

inline constexpr int kMaxBranches = 3;
inline constexpr double kMaxShare = 1000;         ///< stiffer at first than any tissue
inline constexpr double kMinRelaxation_s = 1e-4;  ///< faster than a tick is no memory
inline constexpr double kMaxRelaxation_s = 1e6;

/// How a body's forces relax: a Prony series (docs/method.md, section 24). At time t after a step
/// the body is 1 + sum_k share_k e^{-t/time_k} times as stiff as in slow motion. K <= 3 branches;
/// none: the body has no memory of time.
struct Relaxation {
  Eigen::VectorXd share;   ///< K, > 0: of the stiffness of slow motion
  Eigen::VectorXd time_s;  ///< K, > 0, rising

  Eigen::Index branches() const { return share.size(); }
};

}  // namespace palpate
