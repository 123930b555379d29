#pragma once

#include "libfit/fit/fit_curves.hpp"

namespace palpate::fit {

/// Throws Error on options out of range.
void check_options(const FitOptions& options);

/// Whether curves of any kind were smoothed over neighbouring points.
bool is_smoothed(const FittedCurves& curves);

/// Options of a warm start: bases and family as the earlier fit had them. Throws Error where its
/// curves are of several degrees.
FitOptions as_before(FitOptions options);

/// Strengths of smoothing that a warm start keeps, by kind: those that the earlier fit chose, where
/// none is asked for. Nothing where they are to be chosen or were asked for.
std::optional<std::array<double, kCurveKinds>> kept_strengths(const FitOptions& options);

}  // namespace palpate::fit
