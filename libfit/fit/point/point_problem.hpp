#pragma once

#include "libfit/fit/point/replay.hpp"
#include "libfit/fit/point/start_values.hpp"

// The nonlinear least-squares problem of one point. Ceres stays inside point_problem.cpp.

namespace palpate::fit {

/// Whether anything is fitted at a point.
bool has_unknowns(const PointData& point, const PointCurves& curves);

/// Robust deviation of the sizes of weighted residuals at the curves.
double residual_scale(const PointData& point, const Bases& bases, const PointCurves& curves);

/// Root mean square of the weights of rows that have one.
double root_mean_square_weight(const PointCurves& curves);

/// Increments, the other parts and nuisance values that replay the point's experiments best, from
/// where they are; rows further off than the robust `scale` count less. Changes nothing where that
/// does not lower the loss. One thread, deterministic.
inline constexpr int kMaxIterations = 60;
void refine(const PointData& point, const Bases& bases, double scale, PointCurves& curves,
            int max_iterations = kMaxIterations);

/// The problem to first order about the curves, without loss. Columns: increments of the
/// identified curves in the order of their kinds, the family's other parts, then the unknowns of
/// each experiment's sensor.
struct Linearised {
  Eigen::MatrixXd rows;  ///< d residual / d parameter, 3 per row of each experiment in turn
  Eigen::VectorXd residual;
  Eigen::MatrixXd prior;  ///< likewise of the weak priors and of what nuisance values may be
};
Linearised linearise(const PointData& point, const Bases& bases, const PointCurves& curves);

/// Uncertainty of the curves of a point (M17).
struct PointCovariance {
  /// Second moments of the error of each curve's increments, # x #, in the point's unit of force
  /// squared; empty for a curve that no row depends on.
  std::array<Eigen::MatrixXd, kCurveKinds> increments;
  Eigen::MatrixXd more;                  ///< of PointCurves::more; empty when unknown
  std::vector<NuisanceValues> nuisance;  ///< standard deviations, of each experiment
};

/// From the problem to first order, with noise, its correlation along an experiment and its
/// outliers estimated from the residuals; bounds by projecting seeded draws.
PointCovariance covariance(const PointData& point, const Bases& bases, const PointCurves& curves);

/// Refines a point's identified curves so that replaying its experiments, friction limit
/// included, gives the forces recorded. Changes nothing where that does not lower the loss.
/// bases: in units of the body's length. One thread; deterministic.
void solve_point(const PointData& point, const Bases& bases, PointCurves& curves);

}  // namespace palpate::fit
