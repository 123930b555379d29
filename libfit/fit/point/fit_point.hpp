#pragma once

#include <string>
#include <vector>

#include "libfit/core/stated_error.hpp"
#include "libfit/fit/point/body_bases.hpp"
#include "libfit/fit/point/start_values.hpp"
#include "libfit/fit/rows/curve_rows.hpp"

namespace palpate::fit {

/// Force differences of a point, replayed by the engine's template in SI from stored controls.
struct PointScore {
  double rms_N = 0, max_N = 0;
  double relative = 0;                ///< rms difference over rms force
  std::vector<ForceError> rows;       ///< of each
  int slipped_rows = 0;               ///< replayed as slipping
  std::int32_t worst_experiment = 0;  ///< id, with the row in it
  std::size_t worst_row = 0;
};
/// p: the point, and its row of `fitted`. nuisance: of each experiment in SI, subtracted from its
/// rows; empty for none.
PointScore score_point(const Samples& samples, const PointData& point, double length_m,
                       const Bases& bases_m, const FittedCurves& fitted, Eigen::Index p,
                       const std::vector<NuisanceValues>& nuisance);

/// Result of the fit of one point beside its row of FittedCurves, in SI.
struct PointResult {
  std::vector<NuisanceValues> nuisance;            ///< of each experiment
  std::vector<NuisanceValues> nuisance_deviation;  ///< 0 where it was known
  PointScore score;
  bool is_scored = false;
  bool is_kept = false;  ///< of an earlier fit
};

/// Curves of a body whose points have failed so far: zeros, unknown deviations, and why a point
/// cannot be fitted.
FittedCurves no_curves(const Samples& samples, const BodyData& body, const BodyBases& bases);

/// Curves of one point, dimensionless, from its rows; `problem` says why there are none.
PointCurves identify(const PointData& point, const CurveRows& rows, const BodyBases& bases,
                     const Bases& plain, const FitOptions& options);

/// Fits point p and stores its curves as an asset has them in its row of `fitted`, scored by
/// replaying its experiments.
PointResult fit_point(const Samples& samples, const BodyData& body, Eigen::Index p,
                      const CurveRows& rows, const BodyBases& bases, const Bases& plain,
                      const Bases& si, const FitOptions& options, FittedCurves& fitted);

}  // namespace palpate::fit
