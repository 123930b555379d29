#pragma once

#include "libfit/fit/monotone_least_squares.hpp"

namespace palpate::fit {

/// What the variance of a curve is to be multiplied with for what its basis cannot follow: 1 where
/// the basis is rich enough (docs/method.md, section 14).
/// The rows are fitted on the basis (f) and on one with every piece halved (g), which holds the first.
/// Without bias E (f - g)^2 = s_g^2 - s_f^2, so what is more than that, averaged over the range of
/// the rows, is squared bias. rows: of unit weights; too few for the finer basis give 1.
double basis_inflation(const CurveBasis& basis, const std::vector<CurveRow>& rows, FitLoss loss);

}  // namespace palpate::fit
