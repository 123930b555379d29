#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/fit/report.hpp"

namespace palpate::fit {

/// How presses of other indenters come out, relative as a statement has them (M11a): median and
/// p95. theory: by (M81) alone. left_out: each point with what the others say. fitted: with its
/// own.
struct RadiusReport {
  std::size_t points = 0, rows = 0;
  RelativeErrors as_own_ball, theory, left_out, fitted;
  std::string chosen = "theory alone";  ///< what points without such presses get
};

/// Finds how the stiffness of the body's contacts changes with the indenter's radius beside what
/// (M81) says, k_0 and k_1 of (M83), from straight presses of other indenters at points that
/// `curves` has a curve for: rows of the kind `other` of which ends[i - 1] is the indenter number
/// i. Least squares of relative errors, drawn to 0 by a standard deviation of 0.1. Points without
/// such presses get what those have in common, by distance or on average, whichever predicts left
/// out ones better than none. Does nothing where the curves are of no ball, or no rings.
void identify_radius_effect(FittedCurves& curves, const Samples& others,
                            const std::vector<Indenter>& ends, RadiusReport* report = nullptr);

}  // namespace palpate::fit
