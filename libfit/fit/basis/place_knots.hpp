#pragma once

#include <optional>
#include <vector>

#include "libfit/fit/basis/knot_residuals.hpp"

namespace palpate::fit {

/// At most `most` of the values, evenly taken in their order.
template <class T>
std::vector<T> evenly(const std::vector<T>& all, std::size_t most) {
  if (all.size() <= most) return all;
  std::vector<T> some;
  for (std::size_t i = 0; i < most; ++i) some.push_back(all[i * all.size() / most]);
  return some;
}

/// Knots of the whole body that bring its curves nearest to the rows, each point with increments of
/// its own, and how near they were before and after.
struct PlacedKnots {
  CurveBasis basis;
  double rms_start = 0, rms = 0;  ///< of weighted residuals over each point's rms force
  int iterations = 0;
};

/// Identifies interior knots by Levenberg and Marquardt on KnotResiduals, from those of `start`; a
/// minimum near them, not the least of all. Spacings stay above the least that holds two rows of a
/// typical point. reference: as KnotResiduals. At most 24 points, evenly taken.
PlacedKnots place_knots(const std::vector<PointEvidence>& points, const CurveBasis& start,
                        const CurveBasis& reference, FitLoss loss, int max_iterations = 30);

/// The least spacing that place_knots allows `pieces` pieces over a range.
double min_spacing(const std::vector<PointEvidence>& points, double range, int pieces);

/// The candidate with knots identified from the better of `starts`, its held-out rows predicted on
/// knots found without them; none where residuals hardly shrink, so it cannot pay.
/// normal: basis of f^z.
std::optional<BasisCandidate> identified_candidate(const std::vector<PointEvidence>& points,
                                                   const CurveBasis& normal,
                                                   const std::vector<CurveBasis>& starts,
                                                   const CurveBasis& reference, FitLoss loss);

}  // namespace palpate::fit
