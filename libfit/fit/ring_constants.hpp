#pragma once

#include <array>
#include <optional>
#include <vector>

#include "libfit/fit/point/body_bases.hpp"
#include "libfit/fit/report.hpp"
#include "libfit/fit/rows/curve_rows.hpp"

namespace palpate::fit {

/// What is known of a body's rings besides its drags: the constants of theory, and the standard
/// errors (medians) of the constants of dragged points.
struct RingKnowledge {
  std::array<double, 3> theory, error;
};

/// Lines through the constants of a body's dragged points over the force of their presses
/// (RingPrior). log_force: one per point; constant: ln lambda, mu_0, mu_1 of each. deviation: of
/// a point's constants about the lines. Slopes are medians over pairs of points (Theil 1950, Sen
/// 1968, doi:10.1080/01621459.1968.10480934), drawn to 0 where the points' forces hardly differ; a
/// third of the points may be anything. With `known`, few or uncertain points leave the lines near
/// theory, from which bodies deviate as points do from their line. Not for no point.
RingPrior ring_lines(const std::vector<double>& log_force,
                     const std::array<std::vector<double>, 3>& constant,
                     const std::array<double, 3>& deviation,
                     const std::optional<RingKnowledge>& known = {});

/// Compares the constants of a body's rings with what theory has them be (docs/method.md, section
/// 5): lambda = 2 (1 - nu) / (2 - nu), mu0 = 0.95 mu, mu1 = mu0 / 2R. Only points that were dragged
/// count; those whose lambda is far from the body's say so in their message. No points where the
/// family is another.
RingsReport judge_rings(const Samples& samples, const std::vector<CurveRows>& rows,
                        FittedCurves& fitted);

}  // namespace palpate::fit
