#pragma once

#include "libfit/core/progress.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/fit/options.hpp"
#include "libfit/fit/report.hpp"

namespace palpate {

/// Response curves at every test point, identified from its experiments (docs/method.md, 3 to 5).
/// Rows are predicted by replaying their experiment through the response model, friction limit
/// included; weighted force differences are minimised over the increments of the control values,
/// bounded below by zero, so every curve is monotone and zero at zero. Points are independent but
/// for FitOptions::smoothing, which starts from all of them and leaves each its status.
/// Presses count along the normal alone (straighten_presses()).
/// A point with too little data gets the curves its message names and `underdetermined`; one with
/// none gets zero curves and `failed`; others are not affected. A warm start brings what the fit
/// would on the earlier bases, in the time that the changed points take. cache: filled for the next
/// one; may be options.warm_cache. Throws Error on options out of range and on samples whose arrays
/// do not belong together.
FittedCurves fit_curves(const Samples& samples, const FitOptions& options = {},
                        const Progress& progress = {}, FitReport* report = nullptr,
                        FitCache* cache = nullptr);

}  // namespace palpate
