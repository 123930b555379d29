#pragma once

#include "libfit/fit/point/fit_point.hpp"

namespace palpate::fit {

/// What a fit of all points says of itself; family, smoothing, degree, time and whether it was
/// stopped are left to the caller. rows: in the samples. results: in the order of the fitted
/// points. count: of the worst points listed.
FitReport make_report(std::size_t rows, const BodyBases& bases, const FittedCurves& fitted,
                      const std::vector<PointResult>& results, int count);

}  // namespace palpate::fit
