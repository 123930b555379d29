#pragma once

#include "libfit/core/curves.hpp"
#include "libfit/core/samples.hpp"
#include "tools/scene.hpp"

namespace palpate::tools {

/// Curves at the test points, with basis, residuals and worst points said on stderr.
/// Throws Interrupted when the user stopped it: nothing half-fitted is kept.
FittedCurves fit_samples(const Samples& samples, const FitSection& section, double default_friction, int jobs);

/// Points whose status is not `good`; decides between exit status 0 and 3.
std::size_t points_not_good(const FittedCurves& curves);

}  // namespace palpate::tools
