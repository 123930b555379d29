#pragma once

#include <Eigen/Core>
#include <functional>

#include "libfit/experiments/follow.hpp"

namespace palpate {

/// Residual of experiments whose contacts interact by a coupling, each number over its scale.
using CouplingResidual = std::function<Eigen::VectorXd(const runtime::CouplingView&)>;

/// Residual of experiments of several tools or balls, row by row: the force, over
/// row_scales_N(), and of a tool of several balls the torque, over the same at the lever of its
/// balls. 0 of rows that are not good. They must outlive it.
CouplingResidual coupling_residual(const runtime::AssetView& asset, const Samples& samples,
                                   double depth_m, const PlayedAs& played_as);

/// Identifies the coupling of contacts (M62) on the asset's body, which must be of rings: least
/// squares of the residual over the a_k and b_k of scales length_m 2^k, none negative, with the
/// engine in the loop. On a body that sways contacts also sway together (M62a), which may be all.
/// None where it does not take a tenth off the residual without.
runtime::CouplingView identify_coupling(const runtime::AssetView& asset,
                                        const CouplingResidual& residual, double length_m);

}  // namespace palpate
