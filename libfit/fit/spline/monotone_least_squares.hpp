#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/core/statistics.hpp"
#include "libfit/runtime/base/spline.hpp"

namespace palpate::fit {

using palpate::view;

/// One observation of a curve: value f at x, in whatever unit the caller works in.
/// group: rows with one group are held out together.
struct CurveRow {
  double x = 0, f = 0, weight = 1;
  int group = 0;
  double depth = 0;         ///< that a lateral row has
  bool is_pressed = false;  ///< a normal row before any lateral deflection
};

/// Least strength of a weak prior relative to a row of unit weight: recovers exact curves to
/// 1e-7 and still decides what no row says.
inline constexpr double kWeakPrior = 1e-6;

/// Control values b (size()) from increments a (size() - 1): b_0 = 0, b_{j+1} = b_j + a_j.
Eigen::VectorXd controls_of(const Eigen::VectorXd& increments);

/// d f(x) / d a: the I-spline values at x; zero for x <= 0 (docs/method.md, section 3).
Eigen::VectorXd increment_weights(const runtime::SplineView& spline, double x);

/// Increment j of a curve with slope 1 everywhere: the step between Greville abscissae [m].
Eigen::VectorXd greville_steps(const CurveBasis& basis);

/// A weak prior: it decides what rows leave open. `strength` times (matrix, right side) is appended
/// to a least-squares problem whose rows have a mean square weight of 1.
/// per_noise > 0: the strength grows to per_noise times the rows' relative scatter, so that each
/// row of the matrix weighs like one observation; exact rows leave it at `strength`.
struct WeakPrior {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd target;
  double strength = kWeakPrior;
  double per_noise = 0;
};
/// "Slopes change little": differences of neighbouring slopes over the range.
WeakPrior smoothness_prior(const CurveBasis& basis);
/// "Increments are these".
WeakPrior value_prior(const Eigen::VectorXd& increments);

/// x >= lower minimising |A x - b|, exactly (active sets on a QR factor of A).
/// A: m x n of full column rank, m >= n. Source: Lawson and Hanson, Solving Least Squares Problems
/// (1974), chapter 23.
Eigen::VectorXd bounded_least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b,
                                      const Eigen::VectorXd& lower);

/// Robust deviations from which on a residual counts less (Huber).
inline constexpr double kHuberKnee = 3;

/// sqrt of the robust loss over the size s >= 0 of a weighted residual, 1 near zero: multiply the
/// residual by it and its square is the loss. scale > 0 is a robust standard deviation.
template <class T>
T loss_factor(double scale, const T& size) {
  using std::sqrt;
  const double knee = kHuberKnee * scale;
  if (!(size > knee)) return T(1);
  return sqrt(knee * (2.0 * size - knee)) / size;
}

/// Standard deviation of mostly Gaussian sizes with outliers, 1.4826 times their median.
double robust_deviation(std::vector<double> sizes);

/// Loss of a row far from the curve: `huber` grows linearly past kHuberKnee robust deviations.
enum class FitLoss : std::int8_t { squared = 0, huber = 1 };

/// Increments of the monotone curve nearest to the rows, each at least `lower`.
/// Robust losses by iterated reweighting.
Eigen::VectorXd fit_increments(const CurveBasis& basis, const std::vector<CurveRow>& rows,
                               const Eigen::VectorXd& lower, WeakPrior weak_prior,
                               FitLoss loss = FitLoss::huber);
/// Increments of at least 0, with a smoothness_prior.
Eigen::VectorXd fit_smooth(const CurveBasis& basis, const std::vector<CurveRow>& rows);

/// Value at x of the curve with these increments.
double curve_at(const CurveBasis& basis, const Eigen::VectorXd& increments, double x);

/// Median of the rows over a curve, where that is above 0; 0 without such rows.
double median_ratio(const std::vector<CurveRow>& rows, const CurveBasis& basis,
                    const Eigen::VectorXd& increments);

/// Rows with weights scaled to a mean square of 1.
std::vector<CurveRow> unit_weights(std::vector<CurveRow> rows);

/// Increments of `factor` times a curve on another basis, by least squares on its range.
Eigen::VectorXd transfer(const CurveBasis& from, const Eigen::VectorXd& increments,
                         const CurveBasis& to, double factor);

/// Entries of the lower triangle, row by row, of a symmetric matrix of `size`.
inline Eigen::Index packed_size(Eigen::Index size) { return size * (size + 1) / 2; }

/// The lower triangle of a symmetric matrix, row by row.
Eigen::VectorXd pack_symmetric(const Eigen::MatrixXd& matrix);

/// Standard error [N] of a fitted curve at x [m]: sqrt(w' C w) with w the I-splines at x and C the
/// covariance of the curve's increments, packed: a row of FittedCurves::covariance. 0 for x <= 0,
/// NaN where C is.
double curve_deviation(const runtime::SplineView& spline, const Eigen::VectorXd& covariance,
                       double x);

/// Factor of the covariance of a curve's increments for the bias of its basis
/// (docs/method-identification.md, section 14): 1 + the mean over the rows' range of (f - g)^2 /
/// s^2, f the curve on the basis, s its standard error and g the curve on one with every piece
/// halved. Without bias f and g differ by noise, which is not taken off: the basis was chosen by
/// the same noise, for being close to g. rows: of unit weights; 1 where they are too few for the
/// finer basis.
double basis_inflation(const CurveBasis& basis, const std::vector<CurveRow>& rows,
                       const Eigen::MatrixXd& covariance);

/// Standard errors on either side that hold 90 % of a normal distribution.
inline constexpr double kBand90 = 1.6448536269514722;

}  // namespace palpate::fit
