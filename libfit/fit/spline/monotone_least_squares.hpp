#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "libfit/core/curve_basis.hpp"
#include "libfit/core/statistics.hpp"
#include "libfit/runtime/base/spline.hpp"

namespace palpate::fit {

using palpate::view;

/// One observation of a curve: value f at x, in whatever unit the caller works in.
/// group: rows with one group are held out together.
struct CurveRow {
  double x = 0, f = 0, weight = 1;
  int group = 0;
  double depth = 0;         ///< of a lateral row
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

/// How a row far from the curve counts: `huber` grows linearly past kHuberKnee robust deviations.
enum class FitLoss : std::int8_t { squared = 0, huber = 1 };

/// Increments of the monotone curve nearest to the rows, each at least `lower`.
/// Robust losses by iterated reweighting.
Eigen::VectorXd fit_increments(const CurveBasis& basis, const std::vector<CurveRow>& rows,
                               const Eigen::VectorXd& lower, WeakPrior weak_prior,
                               FitLoss loss = FitLoss::huber);
/// The same of at least 0, with a smoothness_prior.
Eigen::VectorXd fit_smooth(const CurveBasis& basis, const std::vector<CurveRow>& rows);

/// Value at x of the curve with these increments.
double curve_at(const CurveBasis& basis, const Eigen::VectorXd& increments, double x);

/// Rows with weights scaled to a mean square of 1.
std::vector<CurveRow> unit_weights(std::vector<CurveRow> rows);

/// Increments of `factor` times a curve on another basis, by least squares on its range.
Eigen::VectorXd transfer(const CurveBasis& from, const Eigen::VectorXd& increments,
                         const CurveBasis& to, double factor);

}  // namespace palpate::fit
