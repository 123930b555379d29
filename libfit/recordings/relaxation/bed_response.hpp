#pragma once

#include <Eigen/Core>

#include "libfit/core/body.hpp"

namespace palpate::recordings {

/// Forces on rings of unit stiffness that a tool touches at n depths and presses along a path of T
/// places, between which it moves at constant speed (M50); T x n [m], never below 0. A ring is
/// touched where the tool is deeper than it. On a way back it stays behind as long as the body
/// follows slower than the tool leaves, and then its force is 0. Exact in time, up to rounding.
/// A path that begins in contact begins relaxed. time_s: T, rising. No branches: depth beyond the
/// ring.
Eigen::MatrixXd ring_forces(const Eigen::VectorXd& time_s, const Eigen::VectorXd& depth_m,
                            const Relaxation& relaxation, const Eigen::VectorXd& ring_depth_m);

/// How much stiffer than in slow motion the body is, at times since a step: 1 + sum g e^(-t/tau).
Eigen::VectorXd stiffening(const Relaxation& relaxation, const Eigen::VectorXd& time_s);

}  // namespace palpate::recordings
