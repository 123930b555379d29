#pragma once

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "libfit/fit/point/replay.hpp"

// The fit of one point: start values, the nonlinear least-squares problem, uncertainty, score.

namespace palpate::fit {

/// Ratio of the friction limit of a ball at zero depth to the probe's coefficient.
inline constexpr double kSlidingShare = 0.95;

/// gamma R of a ball on thick bodies of nu = 0.45; 0.12 at nu = 0.3, 0.24 at 0.49, and more on thin
/// ones (docs/validation.md, parts of the method).
inline constexpr double kSpreadOfBall = 0.2;

/// A point's ln lambda, mu_0, mu_1 and gamma of its rings, the last two in 1 / the unit of length.
using RingConstants = std::array<double, 4>;

/// The constants that a point's rings are expected to have before its drags are read, and their
/// deviation: by theory, then as the body's dragged points have them. Lengths are over the body's.
/// ln lambda is a line over the logarithm of the force of a press to the end of the basis: what
/// lies deep below a point stiffens its press, and hardly its drags.
struct RingPrior {
  RingConstants constant{-0.405, 0.3, 0, 0};
  double slope = 0;                             ///< of ln lambda
  bool is_of_drags = false;                     ///< else theory's
  bool has_side = true;                         ///< presses have side forces, g of (B1)
  double log_force = 0;                         ///< where the line has `constant`
  RingConstants deviation{0.3, 0.1, 0.3, 0.1};  ///< of a point

  /// True where a press may spread rings: a ball's, of a body that does not relax.
  bool has_spread() const { return constant[3] > 0; }
  /// lambda, mu_0, mu_1 and gamma of a point with this force of a press.
  RingConstants at(double log_force_of_point) const {
    return {std::exp(constant[0] + slope * (log_force_of_point - log_force)), constant[1],
            constant[2], constant[3]};
  }
};

/// The bases of the parts of a body's family, in units of its `length_m` (plain) and in metres
/// (si).
struct BodyBases {
  CurveFamily family = CurveFamily::separable;
  std::vector<CurveBasis> plain = std::vector<CurveBasis>(kCurveKinds), si = plain;
  std::array<BasisReport, kCurveKinds> report;  ///< in metres
  RingPrior rings;                              ///< of a body of rings
};

/// The curves of one point while they are fitted: increments in units of the point's force, on
/// bases in units of the body's length.
struct PointCurves {
  std::array<Eigen::VectorXd, kCurveKinds> increments;
  std::array<Eigen::VectorXd, kCurveKinds> lower;  ///< bounds; > 0 for the lateral curve
  std::array<bool, kCurveKinds> is_identified{false, false, false};  ///< rows speak of it
  std::array<WeakPrior, kCurveKinds>
      weak_prior;  ///< of identified curves, decides where there are no rows
  /// Unknowns of the family's parts after the curve kinds, one after the other (part_controls), in
  /// the same units.
  Eigen::VectorXd constants;
  /// Their expected values, deviations and bounds.
  Eigen::VectorXd constants_expected, constants_deviation, constants_lower, constants_upper;
  double log_force = 0;  ///< of a press to the end of its basis [ln N], where rings ask for it
  double constants_noise = 0;  ///< of the rows' force, to which the deviations compare; 0: unknown
  std::vector<NuisanceValues>
      nuisance;  ///< of each experiment, where a part of it is unknown; else 0
  /// Set by solve_point: robust deviation of the weighted residuals' sizes, the rows' noise over
  /// their force, and the weights of each experiment's rows.
  double scale = 0, noise = 0;
  std::vector<std::vector<double>> weight;
  double friction = 0;  ///< L / f^z where rows do not say otherwise
  std::string problem;  ///< no curve can be made; empty otherwise
  std::string message;  ///< sentences on what is missing and what stands in for it
};

/// Bounded linear fits to a point's rows as curve_rows classifies them, and the documented
/// stand-ins for curves no row speaks of. Rings begin as bodies' are and with the side force of
/// presses, every other part at 0.
PointCurves start_values(const PointData& point, const CurveRows& rows, const BodyBases& bases,
                         const FitOptions& options);

/// True where a point has anything to be fitted.
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
  Eigen::MatrixXd prior;  ///< the same for the weak priors and those of nuisance values
};
Linearised linearise(const PointData& point, const Bases& bases, const PointCurves& curves);

/// Uncertainty of the curves of a point (M17).
struct PointCovariance {
  /// Second moments of the error of each curve's increments, # x #, in the point's unit of force
  /// squared; empty for a curve that no row depends on.
  std::array<Eigen::MatrixXd, kCurveKinds> increments;
  Eigen::MatrixXd constants;             ///< of PointCurves::constants; empty when unknown
  std::vector<NuisanceValues> nuisance;  ///< standard deviations, of each experiment
};

/// From the problem to first order, with noise, its correlation along an experiment and its
/// outliers estimated from the residuals; bounds by projecting seeded draws.
PointCovariance covariance(const PointData& point, const Bases& bases, const PointCurves& curves);

/// Refines a point's identified curves so that replaying its experiments, friction limit
/// included, yields the recorded forces. Changes nothing where that does not lower the loss.
/// bases: in units of the body's length. One thread; deterministic.
void solve_point(const PointData& point, const Bases& bases, PointCurves& curves);

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
