#pragma once

#include "libfit/fit/point/fit_point.hpp"

// From the results of the points, in the points' order, to those of the body.

namespace palpate::fit {

/// Curves of all points, without residuals.
FittedCurves collect_curves(const Samples& samples, const BodyData& body, const BodyBases& bases,
                            const std::vector<PointResult>& results);

/// Fills the residuals of `fitted`.
void collect_residuals(const std::vector<PointResult>& results, FittedCurves& fitted);

/// What a fit of all points says of itself; rows, family, smoothing, degree, time and whether it
/// was stopped are left to the caller. rows: of the curves of each point.
FitReport make_report(const BodyData& body, const std::vector<CurveRows>& rows,
                      const BodyBases& bases, const FittedCurves& fitted,
                      const std::vector<PointResult>& results, const FitOptions& options);

}  // namespace palpate::fit
