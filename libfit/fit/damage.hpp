#pragma once

#include <array>
#include <cstddef>

#include "libfit/core/curves.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/fit/report.hpp"

namespace palpate::fit {

/// Errors of the cycles' rows, relative as a statement has them (M11a), as fitted and without
/// damage.
struct DamageReport {
  std::size_t cycles = 0, rows = 0;
  RelativeErrors damaged, undamaged;
  /// Relative standard deviations of r, m and beta, from what the rows are off by; infinite where
  /// they do not tell a number.
  std::array<double, 3> deviation{};
  double dent = 0;  ///< depth below which nothing answers after the deepest press, over it; median
};

/// How the body softens (M56), from straight presses that go in, out and in again: any experiments
/// of `cycles` that stay on the normal of a test point that `curves` has a curve for (by place).
/// Least squares over r, m and beta of all rows together, each row's force over the largest of its
/// cycle; the curves hold. r is 1 or more unless a dent may be found. m is over the energy under
/// the point's normal curve. None (r 0) where no cycle can be used, or softening takes less than a
/// tenth off the error. reach_m: one and a half contact radii of the probe at the curves' end.
runtime::DamageView identify_damage(const FittedCurves& curves, const Samples& cycles,
                                    DamageReport* report = nullptr, bool may_dent = false);

}  // namespace palpate::fit
