#include "libfit/fit/basis/knot_residuals.hpp"

#include <algorithm>
#include <cmath>

#include "libfit/core/linear_algebra.hpp"

namespace palpate::fit {
namespace {

constexpr double kStep = 1e-5;    // of the range: differences of cubics are good to 1e-10 there
constexpr double kRefused = 1e9;  // residual of knots that are no numbers

// What each spacing has over the least one, of a sum of 1.
Eigen::VectorXd shares(const Eigen::VectorXd& log_ratios) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(log_ratios.size() + 1);
  for (Eigen::Index i = 0; i < log_ratios.size(); ++i) sum[i + 1] = sum[i] + log_ratios[i];
  const Eigen::VectorXd h = (sum.array() - sum.maxCoeff()).exp();
  return h / h.sum();
}

}  // namespace

Eigen::VectorXd log_ratios(const std::vector<double>& knots, double least) {
  Eigen::VectorXd out(static_cast<Eigen::Index>(knots.size()) - 2);
  for (std::size_t i = 0; i + 2 < knots.size(); ++i)
    out[static_cast<Eigen::Index>(i)] =
        std::log((knots[i + 2] - knots[i + 1] - least) / (knots[i + 1] - knots[i] - least));
  return out;
}

std::vector<double> knots_from(const Eigen::VectorXd& log_ratios, double range, double least) {
  const Eigen::VectorXd h = shares(log_ratios);
  const double free = range - least * static_cast<double>(h.size());
  std::vector<double> knots{0.0};
  for (Eigen::Index i = 0; i + 1 < h.size(); ++i)
    knots.push_back(knots.back() + least + free * h[i]);
  knots.push_back(range);
  return knots;
}

Eigen::MatrixXd knots_jacobian(const Eigen::VectorXd& log_ratios, double range, double least) {
  // Ratio j lifts every share after it, at the cost of all by their size:
  // d knot_i / d ratio_j = -free (sum of shares to i) (sum after j), and for j < i what was lifted.
  const Eigen::VectorXd h = shares(log_ratios);
  const double free = range - least * static_cast<double>(h.size());
  const Eigen::Index n = log_ratios.size();
  Eigen::MatrixXd out(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      const double lifted = j < i ? h.segment(j + 1, i - j).sum() : 0;
      out(i, j) = free * (lifted - h.head(i + 1).sum() * h.tail(n - j).sum());
    }
  return out;
}

KnotResiduals::KnotResiduals(const std::vector<PointEvidence>& points, const CurveBasis& reference,
                             int pieces, double least, FitLoss loss)
    : degree_(reference.degree), pieces_(pieces), range_(reference.knots_m.back()), min_(least) {
  const SplineTables tables = tabulate(reference);
  const Eigen::VectorXd lower = Eigen::VectorXd::Zero(reference.size() - 1);
  for (const PointEvidence& evidence : points) {
    WeakPrior weak_prior = smoothness_prior(reference);
    const Eigen::VectorXd increments =
        fit_increments(view(tables), evidence.rows, lower, weak_prior, loss);
    std::vector<double> size;
    double force_square = 0;
    for (const CurveRow& row : evidence.rows) {
      size.push_back(row.weight *
                     std::abs(increment_weights(view(tables), row.x).dot(increments) - row.f));
      force_square += std::pow(row.weight * row.f, 2);
    }
    const auto rows = static_cast<Eigen::Index>(size.size());
    const double scatter = robust_deviation(size);
    const double rms = std::sqrt(force_square / static_cast<double>(rows));
    if (!(rms > 0)) continue;
    PointResiduals point{
        {}, Eigen::VectorXd(rows), Eigen::VectorXd(rows), weak_prior.strength / rms};
    for (Eigen::Index i = 0; i < rows; ++i) {
      const CurveRow& row = evidence.rows[static_cast<std::size_t>(i)];
      point.x.push_back(row.x);
      point.weight[i] = row.weight / rms *
                        std::sqrt(robust_weight(loss, size[static_cast<std::size_t>(i)], scatter));
      point.right[i] = point.weight[i] * row.f;
    }
    residuals_ += static_cast<int>(rows) + pieces + degree_ - 1;
    points_.push_back(std::move(point));
  }
}

CurveBasis KnotResiduals::basis(const Eigen::VectorXd& parameters) const {
  return {degree_, knots_from(parameters, range_, min_)};
}

Eigen::MatrixXd KnotResiduals::system(const PointResiduals& point, const CurveBasis& basis,
                                      const SplineTables& tables) const {
  const WeakPrior weak_prior = smoothness_prior(basis);
  const auto rows = static_cast<Eigen::Index>(point.x.size());
  Eigen::MatrixXd out(rows + weak_prior.matrix.rows(), basis.size() - 1);
  const auto spline = view(tables);
  for (Eigen::Index i = 0; i < rows; ++i)
    out.row(i) = point.weight[i] * increment_weights(spline, point.x[static_cast<std::size_t>(i)]);
  out.bottomRows(weak_prior.matrix.rows()) = point.prior_strength * weak_prior.matrix;
  return out;
}

bool KnotResiduals::operator()(const double* parameters, double* residuals,
                               double* jacobian) const {
  const Eigen::Index knots = pieces_ - 1;
  const Eigen::VectorXd ratios = Eigen::Map<const Eigen::VectorXd>(parameters, knots);
  Eigen::Map<Eigen::VectorXd> left(residuals, residuals_);
  if (!ratios.allFinite()) {
    left.setConstant(kRefused);
    return false;
  }
  const CurveBasis here = basis(ratios);
  const SplineTables tables = tabulate(here);
  struct Moved {
    CurveBasis basis;
    SplineTables tables;
  };
  std::vector<Moved> moved;  // each interior knot back, then on
  const double step = std::min(kStep * range_, 0.25 * min_);
  for (std::size_t k = 1; jacobian != nullptr && k < here.knots_m.size() - 1; ++k)
    for (const double way : {-step, step}) {
      CurveBasis other = here;
      other.knots_m[k] += way;
      moved.push_back({other, tabulate(other)});
    }

  Eigen::MatrixXd by_knot(jacobian != nullptr ? residuals_ : 0, knots);
  const Eigen::VectorXd lower = Eigen::VectorXd::Zero(here.size() - 1);
  Eigen::Index at = 0;
  for (const PointResiduals& point : points_) {
    const Eigen::MatrixXd A = system(point, here, tables);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(A.rows());
    b.head(point.right.size()) = point.right;
    const Eigen::VectorXd increments = bounded_least_squares(A, b, lower);
    left.segment(at, A.rows()) = scale_ * (A * increments - b);
    if (jacobian != nullptr) {
      Eigen::MatrixXd change(A.rows(), knots);
      for (Eigen::Index k = 0; k < knots; ++k) {
        const Moved& back = moved[static_cast<std::size_t>(2 * k)];
        const Moved& on = moved[static_cast<std::size_t>(2 * k + 1)];
        change.col(k) = (system(point, on.basis, on.tables) * increments -
                         system(point, back.basis, back.tables) * increments) /
                        (2 * step);
      }
      std::vector<Eigen::Index> free;
      for (Eigen::Index j = 0; j < increments.size(); ++j)
        if (increments[j] > 0) free.push_back(j);
      by_knot.middleRows(at, A.rows()) = scale_ * outside_columns(A(Eigen::all, free), change);
    }
    at += A.rows();
  }
  if (jacobian != nullptr)
    Eigen::Map<Eigen::MatrixXd>(jacobian, residuals_, knots) =
        by_knot * knots_jacobian(ratios, range_, min_);
  return true;
}

}  // namespace palpate::fit
