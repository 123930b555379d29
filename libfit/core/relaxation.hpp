#pragma once

#include <Eigen/Core>

#include "libfit/runtime/law/relaxation.hpp"

namespace palpate {

/// Relaxation of a body's forces as a Prony series (docs/method-body.md, section 24). At time t
/// after a step the body is 1 + sum_k share_k e^{-t/time_k} times as stiff as in slow motion. K <=
/// runtime::kMaxBranches; none: the body has no memory of time.
struct Relaxation {
  Eigen::VectorXd share;   ///< K, > 0: of the stiffness of slow motion
  Eigen::VectorXd time_s;  ///< K, > 0, rising

  Eigen::Index branches() const { return share.size(); }
};

/// As the law reads it.
inline runtime::RelaxationView relaxation_view(const Relaxation& relaxation) {
  runtime::RelaxationView out;
  out.branches = static_cast<int>(relaxation.branches());
  for (int k = 0; k < out.branches; ++k) {
    out.share[k] = relaxation.share[k];
    out.time_s[k] = relaxation.time_s[k];
    out.fast += out.share[k];
  }
  return out;
}

}  // namespace palpate
