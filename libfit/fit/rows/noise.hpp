#pragma once

#include <vector>

namespace palpate::fit {

/// Standard deviation of a row's force as it grows with the force: sqrt(base^2 + (share f)^2), the
/// usual law of a load cell and its amplifier.
struct NoiseModel {
  double base = 1, share = 0;

  double deviation(double force) const;
};

/// The model nearest to residuals: sizes of weighted residuals over the forces predicted, by
/// reweighted least squares on their squares, those beyond three deviations clipped. Both parts are
/// zero or more; `base` is at least a tenth of the rows' common deviation, so that light touches
/// cannot take the whole weight. Constant (share 0) where growing noise is not significant: its
/// estimate must exceed three of its own errors. Fewer than 20 rows give a constant, too.
/// Source: Carroll and Ruppert, Transformation and Weighting in Regression (1988), chapter 3.
NoiseModel estimate_noise(const std::vector<double>& force, const std::vector<double>& size);

}  // namespace palpate::fit
