#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "libfit/experiments/follow.hpp"
#include "libfit/fit/fit_curves.hpp"

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

namespace fit {

/// Errors of the cycles' rows, relative as a statement has them (M11a), as fitted and without
/// damage.
struct DamageReport {
  std::size_t cycles = 0, rows = 0;
  RelativeErrors damaged, undamaged;
  /// Relative standard deviations of r, m and beta, from the residuals of the rows; infinite where
  /// they do not determine a number.
  std::array<double, 3> deviation{};
};

/// Softening of the body (M56), from straight presses that go in, out and in again: any experiments
/// of `cycles` that stay on the normal of a test point that `curves` has a curve for (by place).
/// Least squares over r, m and beta of all rows together, each row's force over the largest of its
/// cycle; the curves hold. r is 1 or more: no dent stays. m is over the energy under
/// the point's normal curve. None (r 0) where no cycle can be used, or softening takes less than a
/// tenth off the error. reach_m: one and a half contact radii of the probe at the curves' end.
runtime::DamageView identify_damage(const FittedCurves& curves, const Samples& cycles,
                                    DamageReport* report = nullptr);

/// Errors of presses of other indenters, relative as a statement has them (M11a). theory: with k =
/// 0 and w by (M83b). left_out: each point with the effect of the others. fitted: with its own.
struct RadiusReport {
  std::size_t points = 0, rows = 0;
  RelativeErrors as_own_ball, theory, left_out, fitted;
  std::string chosen = "theory alone";  ///< effect of points without such presses
};

/// Finds how the stiffness of the body's contacts changes with the indenter, k and w of (M83): w by
/// each point's own curve (M83b), then both from straight presses of other indenters at points that
/// `curves` has a curve for, rows of the kind `other` of which ends[i - 1] is the indenter number
/// i. Least squares of relative errors, drawn to 0 and to that w by standard deviations of 0.1 and
/// 0.5. Points without such presses get what those have in common, by distance or on average,
/// whichever predicts left out ones better than none. Does nothing where the curves are of no ball,
/// or no rings.
void identify_radius_effect(FittedCurves& curves, const Samples& others,
                            const std::vector<Indenter>& ends, RadiusReport* report = nullptr);

}  // namespace fit
}  // namespace palpate
