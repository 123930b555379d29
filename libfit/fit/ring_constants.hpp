#pragma once

#include <array>
#include <optional>
#include <vector>

#include "libfit/fit/point/body_bases.hpp"
#include "libfit/fit/report.hpp"
#include "libfit/fit/rows/curve_rows.hpp"

namespace palpate::fit {

/// By how much ln lambda, mu_0, mu_1 D and gamma D of a body's points differ from their lines, D
/// the depth of its deepest row: friction by as much there as at first touch.
inline constexpr RingConstants kUsualRings{0.2, 0.03, 0.03, 0.03};

/// Constants of a point's rings, as its drags tell them. error: standard errors of these.
/// log_force: of its press [ln N], see RingPrior.
struct RingPoint {
  double log_force = 0;
  RingConstants constant{}, error{};
};

/// Lines through the constants of a body's dragged points over the force of their presses
/// (RingPrior). deviation: of a point's constants about the lines, above 0. A point weighs
/// 1/(deviation^2 + error^2). Slopes are weighted medians over pairs of points (Theil 1950, Sen
/// 1968, doi:10.1080/01621459.1968.10480934), drawn to 0 where the points' forces hardly differ;
/// of points alike in error a third may be anything. theory, where it is known, counts as one
/// point that its error leaves exact. Not for no point.
RingPrior ring_lines(const std::vector<RingPoint>& points, const RingConstants& deviation,
                     const std::optional<RingConstants>& theory = {});

/// Compares the constants of a body's rings with what theory has them be (docs/method.md, section
/// 5): lambda = 2 (1 - nu) / (2 - nu), mu0 = 0.95 mu, mu1 = mu0 / 2R. Only points that were dragged
/// count; those whose lambda is far from the body's say so in their message. No points where the
/// family is another.
RingsReport judge_rings(const Samples& samples, const std::vector<CurveRows>& rows,
                        FittedCurves& fitted);

}  // namespace palpate::fit
