#pragma once

#include <cstddef>

#include "libfit/core/curves.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/fit/fit_curves.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// What a fit is told: by the samples (friction of their probe, Poisson's ratio of their body), and
/// by [fit]. The one place where stages fill FitOptions. Throws Error on an unknown family.
FitOptions fit_options(const Samples& samples, const FitSection& section, int jobs);

/// Curves at the test points, with basis, residuals and worst points said on stderr, and how the
/// body softens where there are cycles. They carry the probe of the samples.
/// choices: of it warm_start and estimates count. Throws Interrupted when the user stopped it:
/// nothing half-fitted is kept.
FittedCurves fit_samples(const Samples& samples, const FitSection& section, int jobs,
                         const FitOptions& choices = {});

/// Lists points without curves of their own (underdetermined, failed) on stderr, at most a
/// screenful, and `poor` ones where all of these are a quarter of the points or more. Returns how
/// many it lists: exit status 3 rather than 0. Fewer `poor` ones are fitted, and count as such.
/// is_quick: too few rows are what was asked for, so underdetermined points count as fitted.
std::size_t list_bad_points(const FittedCurves& curves, bool is_quick = false);

}  // namespace palpate::tools
