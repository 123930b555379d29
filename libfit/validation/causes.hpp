#pragma once

#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/runtime/asset/view.hpp"
#include "libfit/validation/replay.hpp"
#include "libfit/validation/statement.hpp"

namespace palpate::validation {

/// The causes of an asset's error (M11b), a figure each:
/// interpolation, curve_fit, curve_family, friction_law and float_precision.
/// reference.own must hold presses and drags at held-out points. Paths at other points, and at
/// those whose own curves failed, are left out.
/// engine: the asset's answers along the reference's paths.
std::vector<StatedError> error_causes(const runtime::AssetView& asset, const Reference& reference,
                                      const Replayed& engine, double depth_m, int jobs);

/// The same paths with something simpler in place of the asset's curves, each with its whole
/// error: nearest_point (no interpolation; only where curves and model are given),
/// one_response (the mean curve everywhere), linear (slope at the first row of a press, first_m).
std::vector<StatedError> baseline_errors(const runtime::AssetView& asset,
                                         const Reference& reference, double depth_m, double first_m,
                                         const FittedCurves* curves, const Model* model);

}  // namespace palpate::validation
