#pragma once

#include <memory>
#include <vector>

#include "libfem/materials/pack.hpp"

namespace palpate::fem {

/// Components of a symmetric tensor at a quadrature point: xx, yy, zz, xy, xz, yz.
inline constexpr int kSymmetric = 6;

/// What a relaxing body remembers at a time, batch by batch of ElasticBody, [point][1 + branch]
/// [component] [Pa]: the second Piola-Kirchhoff stress that its shape has in slow motion, then the
/// internal stress of each branch (M14b). Nothing of materials that do not relax. peak: the largest
/// W - U that each point has reached (M54a) [Pa], of materials that soften.
struct MaterialHistory {
  std::vector<PackArray> stress, peak;
};

/// Error of a force by steps in time, relative: what (M14b) leaves of a stress that rises as
/// t^{3/2} where a step is no longer than a sixth of the time since first touch, at the worst ratio
/// of step to branch (tests/libfem/elements).
inline constexpr double kStepError = 0.002;

/// A step of dt_s seconds from a body that remembers `from` (none: at rest) as a potential, batch
/// by batch: (M14a) with stiffening 1 + sum_k g_k z_k and the stress H held meanwhile,
/// [point][component] [Pa]. peak: (M54b), of materials that soften.
struct MaterialStep {
  std::shared_ptr<const MaterialHistory> from;
  double dt_s = 0;
  std::vector<double> stiffening;
  std::vector<PackArray> held, peak;

  double max_stiffening() const;
};

/// A branch over a step of dt = share of its time: e^{-dt/tau} and z = (1 - e^{-dt/tau}) /
/// (dt/tau), which is exact where stress changes evenly over the step (M14b). 0 <= dt_over_time <=
/// inf. Source: Taylor, Pister and Goudreau 1970, doi:10.1002/nme.1620020106.
struct BranchDecay {
  double kept, taken;
};
BranchDecay branch_decay(double dt_over_time);

}  // namespace palpate::fem
