#pragma once

#include "libfit/fit/report.hpp"
#include "libfit/fit/rows/curve_rows.hpp"

namespace palpate::fit {

/// Compares the constants of a body's rings with what theory has them be (docs/method.md, section
/// 5): lambda = 2 (1 - nu) / (2 - nu), mu0 = 0.95 mu, mu1 = mu0 / 2R. Only points that were dragged
/// count; those whose lambda is far from the body's say so in their message. No points where the
/// family is another.
RingsReport judge_rings(const Samples& samples, const std::vector<CurveRows>& rows,
                        FittedCurves& fitted);

}  // namespace palpate::fit
