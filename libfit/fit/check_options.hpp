#pragma once

#include "libfit/fit/fit_curves.hpp"

namespace palpate::fit {

/// Throws Error on options out of range.
void check_options(const FitOptions& options);

/// Whether curves of any kind were smoothed over neighbouring points.
bool is_smoothed(const FittedCurves& curves);

/// Options of a warm start: bases and family as the earlier fit had them and, where it chose them
/// and nothing else is asked for, its strengths of smoothing. Throws Error where the earlier curves are of several degrees.
FitOptions as_before(FitOptions options);

}  // namespace palpate::fit
