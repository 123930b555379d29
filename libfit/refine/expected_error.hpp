#pragma once

#include <vector>

#include "libfit/core/curves.hpp"

namespace palpate {

/// What interpolation between test points is expected to get wrong at each vertex of a model,
/// relative to the force there (M12a). #V; 0 where not covered.
/// curves: what the model was refined from, on the same triangles. floor_N: forces below it count
/// as it. Curves are compared at four depths; normal force and limit force both count.
/// Exact up to third order for smooth fields; of features smaller than the spacing it sees that
/// neighbours disagree, not how much is hidden between them.
std::vector<double> expected_errors(const FittedCurves& curves, const Model& model,
                                    const Triangles& triangles, double floor_N);

}  // namespace palpate
