#pragma once

#include <array>
#include <string>
#include <vector>

#include "libfit/fit/point/body_bases.hpp"
#include "libfit/fit/point/score.hpp"
#include "libfit/fit/point/start_values.hpp"
#include "libfit/fit/report.hpp"
#include "libfit/fit/rows/curve_rows.hpp"

namespace palpate::fit {

/// What one point's fit leaves behind, in SI. Controls are zeros of the bases' sizes when it
/// failed.
struct PointResult {
  std::vector<Eigen::VectorXd> control;  ///< of each part of the family
  FitStatus status = FitStatus::failed;
  std::string message;
  std::array<Eigen::VectorXd, kCurveKinds> covariance;  ///< packed [N^2], NaN where unknown
  std::vector<Eigen::VectorXd> deviation;               ///< of each part's numbers; FittedCurves
  std::vector<NuisanceValues> nuisance;                 ///< of each experiment, SI
  std::vector<NuisanceValues> nuisance_deviation;       ///< SI; 0 where it was known
  PointScore score;
  bool is_scored = false;
  bool is_kept = false;  ///< of an earlier fit
};

/// A result without curves.
PointResult no_curves(const BodyBases& bases, const std::string& why);

/// Curves of one point, dimensionless, from its rows; `problem` says why there are none.
PointCurves identify(const PointData& point, const CurveRows& rows, const BodyBases& bases,
                     const Bases& plain, const FitOptions& options);

/// Curves of one point as an asset stores them, scored by replaying its experiments.
PointResult fit_point(const Samples& samples, const PointData& point, const CurveRows& rows,
                      double length_m, const BodyBases& bases, const Bases& plain, const Bases& si,
                      const FitOptions& options);

}  // namespace palpate::fit
