#pragma once

#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/validation/statement.hpp"

namespace palpate::validation {

/// The experiments of one point replayed with given curves, row against row: the law of section 4
/// on the local quadric (docs/method.md, M11), as the fit sees it. row: of `curves`.
/// Good rows only; a drag or path ends at its first row that is not.
std::vector<ComparedRow> predicted_rows(const Samples& samples, std::int32_t point,
                                        const CurveSet& curves, Eigen::Index row);

}  // namespace palpate::validation
