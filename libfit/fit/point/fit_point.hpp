#pragma once

#include <array>
#include <limits>
#include <string>
#include <vector>

#include "libfit/fit/point/body_bases.hpp"
#include "libfit/fit/point/start_values.hpp"
#include "libfit/fit/rows/curve_rows.hpp"
#include "libfit/fit/rows/score.hpp"

namespace palpate::fit {

/// What one point's fit leaves behind, in SI. Controls are zeros of the bases' sizes when it
/// failed.
struct PointResult {
  std::vector<Eigen::VectorXd> control;  ///< of each part of the family
  FitStatus status = FitStatus::failed;
  std::string message;
  std::array<Eigen::VectorXd, kCurveKinds> covariance;  ///< packed [N^2], NaN where unknown
  std::vector<Sensor> sensor;                           ///< of each experiment, SI
  std::vector<Sensor> sensor_deviation;                 ///< SI; 0 where it was known
  PointScore score;
  bool is_scored = false;
  std::string rows_hash;
  bool is_kept = false;  ///< of an earlier fit, there in row earlier_row
  Eigen::Index earlier_row = -1;
  double depth_m = 0;  ///< deepest row fitted
  /// Where the rows of each curve end; NaN without any.
  Eigen::RowVector3d curve_end_m =
      Eigen::RowVector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  bool states_errors = false;  ///< some row has a force error of its own
  RowCounts rows;
};

/// A result without curves.
PointResult no_curves(const BodyBases& bases, const std::string& why);

/// Curves of one point, dimensionless, from its rows; `problem` says why there are none.
PointCurves identify(const PointData& point, const PointRows& rows, const BodyBases& bases,
                     const Bases& plain, const FitOptions& options);

/// Curves of one point as an asset stores them, scored by replaying its experiments.
PointResult fit_point(const Samples& samples, const PointData& point, const PointRows& rows,
                      double length_m, const BodyBases& bases, const Bases& plain, const Bases& si,
                      const FitOptions& options);

}  // namespace palpate::fit
