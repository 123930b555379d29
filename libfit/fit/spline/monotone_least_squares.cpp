#include "libfit/fit/spline/monotone_least_squares.hpp"

#include <algorithm>
#include <cmath>

#include "libfit/core/linear_algebra.hpp"

namespace palpate::fit {
namespace {

// Weight of a squared residual in reweighted least squares, loss'(s) / 2s: 1 near zero, and where
// the scale, a robust deviation, is 0.
double robust_weight(double size, double scale) {
  if (!(scale > 0)) return 1;
  const double z = size / (kHuberKnee * scale);
  return z > 1 ? 1 / z : 1;
}

CurveBasis halved(const CurveBasis& basis) {
  CurveBasis fine{basis.degree, {basis.knots_m.front()}};
  for (std::size_t i = 1; i < basis.knots_m.size(); ++i) {
    fine.knots_m.push_back(0.5 * (basis.knots_m[i - 1] + basis.knots_m[i]));
    fine.knots_m.push_back(basis.knots_m[i]);
  }
  return fine;
}

}  // namespace

Eigen::VectorXd controls_of(const Eigen::VectorXd& increments) {
  Eigen::VectorXd control(increments.size() + 1);
  control[0] = 0;
  for (Eigen::Index j = 0; j < increments.size(); ++j) control[j + 1] = control[j] + increments[j];
  return control;
}

Eigen::VectorXd increment_weights(const runtime::SplineView& spline, double x) {
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(spline.size() - 1);
  if (!(x > 0)) return weights;
  const auto local = runtime::spline_weights(spline, runtime::find_piece(spline, x), x);
  weights.head(local.first).setOnes();
  double sum = 0;
  for (int k = spline.degree; k >= 1; --k) {
    sum += local.value[k];
    weights[local.first + k - 1] = sum;
  }
  return weights;
}

Eigen::VectorXd greville_steps(const CurveBasis& basis) {
  const int last = basis.pieces();
  const auto knot = [&](int i) { return basis.knots_m[std::clamp(i, 0, last)]; };
  Eigen::VectorXd steps(basis.size() - 1);
  for (int j = 0; j < basis.size() - 1; ++j)
    steps[j] = (knot(j + 1) - knot(j + 1 - basis.degree)) / basis.degree;
  return steps;
}

WeakPrior smoothness_prior(const CurveBasis& basis) {
  const Eigen::VectorXd steps = greville_steps(basis);
  const double range = basis.knots_m.back();
  const Eigen::Index n = steps.size();
  WeakPrior weak_prior{Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n), kWeakPrior, 1};
  for (Eigen::Index j = 0; j + 1 < n; ++j) {
    weak_prior.matrix(j, j) = -range / steps[j];
    weak_prior.matrix(j, j + 1) = range / steps[j + 1];
  }
  weak_prior.matrix.row(n - 1).setConstant(1e-3);  // full rank when no row says anything at all
  return weak_prior;
}

WeakPrior value_prior(const Eigen::VectorXd& increments) {
  const Eigen::Index n = increments.size();
  return {Eigen::MatrixXd::Identity(n, n), increments, kWeakPrior, double(n)};
}

Eigen::VectorXd bounded_least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b,
                                      const Eigen::VectorXd& lower) {
  const auto [R, rotated] = triangular_system(A, b - A * lower);
  return lower + nonnegative_least_squares(R, rotated);
}

double robust_deviation(std::vector<double> sizes) { return 1.4826 * median(std::move(sizes)); }

Eigen::VectorXd fit_increments(const CurveBasis& basis, const std::vector<CurveRow>& rows,
                               const Eigen::VectorXd& lower, WeakPrior weak_prior, FitLoss loss) {
  const SplineTables tables = tabulate(basis);
  const Eigen::Index m = rows.size(), n = lower.size();
  Eigen::MatrixXd A(m, n);
  Eigen::VectorXd b(m), weight = Eigen::VectorXd::Ones(m);
  double largest = 0;
  for (Eigen::Index i = 0; i < m; ++i) {
    const CurveRow& row = rows[i];
    A.row(i) = row.weight * increment_weights(view(tables), row.x);
    b[i] = row.weight * row.f;
    largest = std::max(largest, std::abs(row.f));
  }
  Eigen::MatrixXd system(m + weak_prior.matrix.rows(), n);
  Eigen::VectorXd right(m + weak_prior.matrix.rows()), increments;
  // The scatter needs a few rounds to settle; reweighting reaches 1e-3 of the noise in 12.
  const int rounds = m <= n ? 1 : loss == FitLoss::squared ? 3 : 12;
  for (int round = 0; round < rounds; ++round) {
    system << weight.asDiagonal() * A, weak_prior.strength * weak_prior.matrix;
    right << weight.cwiseProduct(b), weak_prior.strength * weak_prior.target;
    increments = bounded_least_squares(system, right, lower);
    if (round + 1 == rounds) break;
    const Eigen::VectorXd size = (A * increments - b).cwiseAbs();
    const double scatter =
        robust_deviation({size.data(), size.data() + m}) * std::sqrt(double(m) / double(m - n));
    for (Eigen::Index i = 0; i < m && loss == FitLoss::huber; ++i)
      weight[i] = std::sqrt(robust_weight(size[i], scatter));
    if (largest > 0)
      weak_prior.strength = std::max(weak_prior.strength, weak_prior.per_noise * scatter / largest);
  }
  return increments;
}

Eigen::VectorXd fit_smooth(const CurveBasis& basis, const std::vector<CurveRow>& rows) {
  return fit_increments(basis, rows, Eigen::VectorXd::Zero(basis.size() - 1),
                        smoothness_prior(basis));
}

double curve_at(const CurveBasis& basis, const Eigen::VectorXd& increments, double x) {
  const SplineTables tables = tabulate(basis);
  return increment_weights(view(tables), x).dot(increments);
}

double median_ratio(const std::vector<CurveRow>& rows, const CurveBasis& basis,
                    const Eigen::VectorXd& increments) {
  const SplineTables tables = tabulate(basis);
  std::vector<double> ratios;
  for (const CurveRow& row : rows) {
    const double f = increment_weights(view(tables), row.x).dot(increments);
    if (f > 0) ratios.push_back(row.f / f);
  }
  return median(ratios);
}

std::vector<CurveRow> unit_weights(std::vector<CurveRow> rows) {
  double sum = 0;
  for (const CurveRow& row : rows) sum += row.weight * row.weight;
  const double scale = sum > 0 ? std::sqrt(double(rows.size()) / sum) : 1;
  for (CurveRow& row : rows) row.weight *= scale;
  return rows;
}

Eigen::VectorXd transfer(const CurveBasis& from, const Eigen::VectorXd& increments,
                         const CurveBasis& to, double factor) {
  if (from.degree == to.degree && from.knots_m == to.knots_m) return factor * increments;
  const SplineTables source = tabulate(from);
  std::vector<CurveRow> rows;
  const int count = 6 * to.size();
  for (int i = 1; i <= count; ++i) {
    const double x = to.knots_m.back() * i / count;
    rows.push_back({x, factor * increment_weights(view(source), x).dot(increments), 1, 0});
  }
  WeakPrior weak_prior = smoothness_prior(to);
  weak_prior.per_noise = 0;
  return fit_increments(to, rows, Eigen::VectorXd::Zero(to.size() - 1), weak_prior,
                        FitLoss::squared);
}

Eigen::VectorXd pack_symmetric(const Eigen::MatrixXd& matrix) {
  Eigen::VectorXd packed(packed_size(matrix.rows()));
  Eigen::Index at = 0;
  for (Eigen::Index i = 0; i < matrix.rows(); ++i)
    for (Eigen::Index j = 0; j <= i; ++j) packed[at++] = matrix(i, j);
  return packed;
}

double curve_deviation(const runtime::SplineView& spline, const Eigen::VectorXd& covariance,
                       double x) {
  if (!(x > 0)) return 0;
  const Eigen::VectorXd weight = increment_weights(spline, x);
  double square = 0;
  Eigen::Index at = 0;
  for (Eigen::Index i = 0; i < weight.size(); ++i)
    for (Eigen::Index j = 0; j <= i; ++j)
      square += (i == j ? 1 : 2) * covariance[at++] * weight[i] * weight[j];
  return square < 0 ? 0 : std::sqrt(square);  // rounding; NaN stays
}

double basis_inflation(const CurveBasis& basis, const std::vector<CurveRow>& rows,
                       const Eigen::MatrixXd& covariance) {
  const CurveBasis fine = halved(basis);
  if (rows.size() < 2 * std::size_t(fine.size())) return 1;
  double range = 0;
  for (const CurveRow& row : rows) range = std::max(range, row.x);
  const SplineTables coarse_tables = tabulate(basis), fine_tables = tabulate(fine);
  const Eigen::VectorXd f = fit_smooth(basis, rows), g = fit_smooth(fine, rows);
  constexpr int kGrid = 40;
  double sum = 0;
  for (int i = 1; i <= kGrid; ++i) {
    const double x = range * i / kGrid;
    const Eigen::VectorXd w = increment_weights(view(coarse_tables), x);
    const double apart = w.dot(f) - increment_weights(view(fine_tables), x).dot(g);
    const double square = w.dot(covariance * w);
    if (square > 0) sum += apart * apart / square / kGrid;
  }
  return 1 + sum;
}

}  // namespace palpate::fit
