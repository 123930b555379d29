#pragma once

#include "libfit/fit/point/point_problem.hpp"

namespace palpate::fit {

/// How far the curves of a point may be off (M17).
struct PointCovariance {
  /// Second moments of the error of each curve's increments, # x #, in the point's unit of force
  /// squared; empty for a curve that no row speaks of.
  std::array<Eigen::MatrixXd, kCurveKinds> increments;
  Eigen::MatrixXd more;  ///< of PointCurves::more; empty when unknown
  std::vector<NuisanceValues>
      nuisance;        ///< standard deviations of what was unknown of each experiment's
  double freedom = 0;  ///< scalar rows less effective parameters
};

/// From the problem to first order, with noise, its correlation along an experiment and its
/// outliers estimated from the residuals; bounds by projecting seeded draws.
PointCovariance covariance(const PointData& point, const Bases& bases, const PointCurves& curves);

/// Mean of (P(x + e) - x)(P(x + e) - x)' over draws of e from N(0, covariance), P the nearest in
/// the metric of the covariance's inverse that is at least `lower`. The covariance itself where no
/// bound is within reach. x >= lower. Seeded: same input, same bits.
Eigen::MatrixXd bounded_moments(const Eigen::VectorXd& x, const Eigen::MatrixXd& covariance,
                                const Eigen::VectorXd& lower);

}  // namespace palpate::fit
