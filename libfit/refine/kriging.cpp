#include "libfit/refine/kriging.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "libfit/core/linear_algebra.hpp"
#include "libfit/core/statistics.hpp"

namespace palpate {
namespace {

// In spacings of the points, and nuggets in variances of the field. None is chosen by hand: each
// counts as much as the points make it likely.
constexpr double kRanges[] = {2, 4, 8, 16}, kTurns[] = {1, 4}, kNuggets[] = {1e-3, 1e-2, 1e-1, 1};
constexpr double kLikely = 1e-3;  // of the likeliest: less is not kept
constexpr Eigen::Index kJudged = 300, kAtOnce = 256;

double spacing_of(const Points& position) {
  std::vector<double> nearest;
  for (Eigen::Index i = 0; i < position.rows(); ++i) {
    Eigen::VectorXd away = (position.rowwise() - position.row(i)).rowwise().norm();
    away[i] = std::numeric_limits<double>::infinity();
    nearest.push_back(away.minCoeff());
  }
  return upper_median(std::move(nearest));
}

}  // namespace

// Matern's with smoothness 3/2 (Stein 1999).
Eigen::MatrixXd Kriging::between(const Covariance& covariance, const Points& a,
                                 const Points& a_normal, const Points& b, const Points& b_normal) {
  const double turn2 = covariance.turn_m * covariance.turn_m;
  Eigen::MatrixXd out(a.rows(), b.rows());
  for (Eigen::Index j = 0; j < b.rows(); ++j)
    for (Eigen::Index i = 0; i < a.rows(); ++i) {
      double away2 = (a.row(i) - b.row(j)).squaredNorm();
      if (turn2 > 0) away2 += turn2 * (a_normal.row(i) - b_normal.row(j)).squaredNorm();
      const double r = std::sqrt(3 * away2) / covariance.range_m;
      out(i, j) = (1 + r) * std::exp(-r);
    }
  return out;
}

struct Kriging::FittedCovariance {
  double log_likelihood = -std::numeric_limits<double>::infinity(), mean = 0;
  Eigen::VectorXd weight, left_out;
};

Kriging::FittedCovariance Kriging::fitted(const Covariance& of, const Points& position,
                                          const Points& normal, const Eigen::VectorXd& value) {
  const Eigen::Index n = value.size();
  Eigen::MatrixXd covariance = between(of, position, normal, position, normal);
  covariance.diagonal().array() += of.nugget;
  const auto [inverse, log_determinant, is_positive] = cholesky_inverse(covariance);
  if (!is_positive) return {};
  const Eigen::VectorXd of_ones = inverse.rowwise().sum();
  const double total = of_ones.sum();
  FittedCovariance out;
  out.mean = of_ones.dot(value) / total;
  const Eigen::VectorXd residual = value.array() - out.mean;
  out.weight = inverse * residual;
  const double squares = std::max(residual.dot(out.weight), std::numeric_limits<double>::min());
  out.log_likelihood =
      -0.5 * (double(n - 1) * std::log(squares) + log_determinant + std::log(total));
  const Eigen::VectorXd precision = inverse.diagonal() - of_ones.cwiseProduct(of_ones) / total;
  out.left_out = value - out.weight.cwiseQuotient(precision);
  return out;
}

Kriging::Kriging(const Points& position, const Points& normal, const Eigen::VectorXd& value)
    : position_(position), normal_(normal), left_out_(Eigen::VectorXd::Zero(value.size())) {
  const double spacing_m = spacing_of(position);
  std::vector<Eigen::Index> some;
  for (Eigen::Index p = 0; p < value.size(); p += 1 + (value.size() - 1) / kJudged)
    some.push_back(p);
  const bool is_all = std::ssize(some) == value.size();
  const bool has_normals = normal.rows() > 0;
  const Points some_position = position(some, Eigen::all),
               some_normal = has_normals ? Points(normal(some, Eigen::all)) : normal;
  std::vector<Covariance> covariances;
  std::vector<FittedCovariance> tried;
  double likeliest = -std::numeric_limits<double>::infinity(), sum = 0;
  for (const double turn : kTurns)
    for (const double range : kRanges)
      for (const double nugget : kNuggets) {
        if (!has_normals && turn != kTurns[0]) continue;
        covariances.push_back({range * spacing_m, has_normals ? turn * spacing_m : 0, nugget});
        tried.push_back(fitted(covariances.back(), some_position, some_normal, value(some)));
        likeliest = std::max(likeliest, tried.back().log_likelihood);
      }
  for (std::size_t k = 0; k < tried.size(); ++k) {
    const double share = std::exp(tried[k].log_likelihood - likeliest);
    if (!(share > kLikely)) continue;
    FittedCovariance all =
        is_all ? std::move(tried[k]) : fitted(covariances[k], position, normal, value);
    left_out_ += share * all.left_out;
    sum += share;
    kept_.push_back({covariances[k], share, all.mean, std::move(all.weight)});
  }
  left_out_ /= sum;
  for (KeptCovariance& k : kept_) k.share /= sum;
}

Eigen::VectorXd Kriging::at(const Points& position, const Points& normal) const {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(position.rows());
  for (Eigen::Index first = 0; first < out.size(); first += kAtOnce) {
    const Eigen::Index count = std::min(kAtOnce, out.size() - first);
    for (const KeptCovariance& k : kept_) {
      const Eigen::VectorXd residual =
          between(k.covariance, position.middleRows(first, count),
                  normal_.rows() > 0 ? Points(normal.middleRows(first, count)) : normal_, position_,
                  normal_) *
          k.weight;
      out.segment(first, count).array() += k.share * (k.mean + residual.array());
    }
  }
  return out;
}

}  // namespace palpate
