#include "libfit/fit/basis_bias.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace palpate::fit {
namespace {

constexpr int kGrid = 40;

CurveBasis halved(const CurveBasis& basis) {
  CurveBasis fine{basis.degree, {basis.knots_m.front()}};
  for (std::size_t i = 1; i < basis.knots_m.size(); ++i) {
    fine.knots_m.push_back(0.5 * (basis.knots_m[i - 1] + basis.knots_m[i]));
    fine.knots_m.push_back(basis.knots_m[i]);
  }
  return fine;
}

// A curve on a grid, its variance there per unit of noise, and the noise that it leaves.
struct Look {
  Eigen::VectorXd value, variance;
  double noise = 0;
};

Look look(const CurveBasis& basis, const std::vector<CurveRow>& rows, FitLoss loss, double range) {
  const SplineTables tables = tabulate(basis);
  const auto spline = view(tables);
  const Eigen::Index n = basis.size() - 1;
  Faint faint = faint_smoothness(basis);
  const Eigen::VectorXd increments =
      fit_increments(spline, rows, Eigen::VectorXd::Zero(n), faint, loss);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(n, n);
  std::vector<double> sizes;
  for (const CurveRow& row : rows) {
    const Eigen::VectorXd w = increment_weights(spline, row.x);
    information += row.weight * row.weight * w * w.transpose();
    sizes.push_back(row.weight * std::abs(w.dot(increments) - row.f));
  }
  Look out{Eigen::VectorXd(kGrid), Eigen::VectorXd(kGrid), robust_deviation(sizes)};
  information += faint.strength * faint.strength * faint.matrix.transpose() * faint.matrix;
  const Eigen::LLT<Eigen::MatrixXd> factor(information);
  for (int i = 0; i < kGrid; ++i) {
    const Eigen::VectorXd w = increment_weights(spline, range * (i + 1) / kGrid);
    out.value[i] = w.dot(increments);
    out.variance[i] = w.dot(factor.solve(w));
  }
  return out;
}

}  // namespace

double basis_inflation(const CurveBasis& basis, const std::vector<CurveRow>& rows, FitLoss loss) {
  const CurveBasis fine = halved(basis);
  const auto count = static_cast<double>(rows.size());
  if (count < 2 * fine.size()) return 1;
  double range = 0;
  for (const CurveRow& row : rows) range = std::max(range, row.x);
  const Look f = look(basis, rows, loss, range), g = look(fine, rows, loss, range);
  const double own = g.noise * g.noise * count / (count - fine.size()) * f.variance.mean();
  if (!(own > 0)) return 1;
  return 1 + (f.value - g.value).squaredNorm() / kGrid / own;
}

}  // namespace palpate::fit
