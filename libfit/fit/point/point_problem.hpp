#pragma once

#include "libfit/fit/point/replay.hpp"
#include "libfit/fit/point/start_values.hpp"

// The nonlinear least-squares problem of one point. Ceres stays inside point_problem.cpp.

namespace palpate::fit {

/// What is fitted at a point as one vector: increments of the identified curves in the order of
/// their kinds, of the family's other parts, then what is unknown of each experiment's sensor.
Eigen::VectorXd pack(const PointCurves& curves, const PointData& point);

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

/// The problem to first order about the curves, without loss. Columns as in pack.
struct Linearised {
  Eigen::MatrixXd rows;  ///< d residual / d parameter, 3 per row of each experiment in turn
  Eigen::VectorXd residual;
  Eigen::MatrixXd prior;  ///< likewise of the weak priors and of what nuisance values may be
};
Linearised linearise(const PointData& point, const Bases& bases, const PointCurves& curves);

/// Refines a point's identified curves so that replaying its experiments, friction limit
/// included, gives the forces recorded. Changes nothing where that does not lower the loss.
/// bases: in units of the body's length. One thread; deterministic.
void solve_point(const PointData& point, const Bases& bases, PointCurves& curves);

}  // namespace palpate::fit
