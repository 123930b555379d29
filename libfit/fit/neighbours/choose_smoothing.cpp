#include "libfit/fit/neighbours/choose_smoothing.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "libfit/core/text.hpp"

namespace palpate::fit {
namespace {

constexpr int kFolds = 5;
constexpr Eigen::Index kFewestPoints = 8;  // a standard error needs some
constexpr double kMinGain = 0.1;           // of what exact curves would gain
constexpr double kExact = 1e-3;            // of force: curves known better need no neighbours
constexpr double kMinStrength = 1, kMaxStrength = 1e6, kStep = 4;
constexpr double kTolerance = 1e-5;  // of a solution that only predicts

// A row that a fold does not see, and its force per increment.
struct Unseen {
  std::size_t point = 0;
  Eigen::VectorXd force;
  double measured = 0, weight = 0;  // weight: over the noise
};

struct Fold {
  GraphQuadratic quadratic;
  std::vector<Unseen> rows;
};

struct PointFold {
  Eigen::VectorXd increments;   // in units of SmoothingData
  Eigen::MatrixXd information;  // of the rows seen and of what is known beforehand, unit noise
  std::vector<Unseen> unseen;
};

// The point's rows but for a fold, which is judged as in held_out.cpp: the deepest abscissa is
// always seen, and so is the first. fold -1: all are seen.
PointFold fit_fold(const SmoothingData& data, const runtime::SplineView& spline, std::size_t point,
                   int fold, FitLoss loss) {
  const std::vector<CurveRow>& rows = data.rows[point];
  const auto row_index = static_cast<Eigen::Index>(point);
  const Eigen::VectorXd unit = data.unit.row(row_index);
  int last = 0;
  for (const CurveRow& row : rows) last = std::max(last, row.group);
  std::vector<CurveRow> seen;
  PointFold out;
  for (const CurveRow& row : rows) {
    const bool is_seen = row.group == 0 || row.group == last || row.group % kFolds != fold;
    if (is_seen) {
      seen.push_back(row);
      continue;
    }
    out.unseen.push_back(
        {point, unit.cwiseProduct(increment_weights(spline, row.x)), row.f, row.weight});
  }
  WeakPrior weak_prior = smoothness_prior(data.basis);
  const Eigen::Index n = data.estimate.cols();
  out.increments =
      fit_increments(spline, seen, Eigen::VectorXd::Zero(n), weak_prior, loss).cwiseQuotient(unit);
  const Eigen::MatrixXd prior = weak_prior.strength * weak_prior.matrix * unit.asDiagonal();
  out.information = prior.transpose() * prior;
  for (const CurveRow& row : seen) {
    const Eigen::VectorXd force = unit.cwiseProduct(increment_weights(spline, row.x));
    out.information += row.weight * row.weight * force * force.transpose();
  }
  return out;
}

// Variance of a row of unit weight that makes the curve's covariance of its information.
double row_variance(const SmoothingData& data, const runtime::SplineView& spline, std::size_t point,
                    FitLoss loss) {
  const PointFold all = fit_fold(data, spline, point, -1, loss);
  return (data.covariance[point] * all.information).trace() /
         static_cast<double>(data.estimate.cols());
}

std::vector<Fold> make_folds(const SmoothingData& data, FitLoss loss) {
  const SplineTables tables = tabulate(data.basis);
  const auto spline = view(tables);
  const Eigen::Index n = data.estimate.cols();
  std::vector<double> variance;
  for (std::size_t p = 0; p < data.rows.size(); ++p)
    variance.push_back(row_variance(data, spline, p, loss));
  std::vector<Fold> folds;
  for (int fold = 0; fold < kFolds; ++fold) {
    Controls estimate(data.estimate.rows(), n);
    std::vector<Eigen::MatrixXd> covariance;
    Fold out;
    for (std::size_t p = 0; p < data.rows.size(); ++p) {
      PointFold found = fit_fold(data, spline, p, fold, loss);
      estimate.row(static_cast<Eigen::Index>(p)) = found.increments;
      covariance.push_back(variance[p] *
                           found.information.llt().solve(Eigen::MatrixXd::Identity(n, n)));
      for (Unseen& row : found.unseen) {
        row.weight /= std::sqrt(variance[p]);
        out.rows.push_back(std::move(row));
      }
    }
    out.quadratic = make_quadratic(estimate, covariance, data.edges);
    folds.push_back(std::move(out));
  }
  return folds;
}

// Means over each point's rows that some fold did not see; points without any are left out.
class PointMeans {
 public:
  PointMeans(const std::vector<Fold>& folds, std::size_t points) : count_(points, 0) {
    for (const Fold& fold : folds)
      for (const Unseen& row : fold.rows) ++count_[row.point];
  }
  std::size_t points() const {
    return count_.size() - static_cast<std::size_t>(std::count(count_.begin(), count_.end(), 0.0));
  }
  template <class Value>
  std::vector<double> of(const std::vector<Fold>& folds, const Value& value) const {
    std::vector<double> sum(count_.size(), 0), means;
    for (std::size_t f = 0; f < folds.size(); ++f)
      for (const Unseen& row : folds[f].rows) sum[row.point] += value(f, row);
    for (std::size_t p = 0; p < sum.size(); ++p)
      if (count_[p] > 0) means.push_back(sum[p] / count_[p]);
    return means;
  }

 private:
  std::vector<double> count_;
};

struct MeanAndError {
  double value = 0, error = 0;  // standard
};
MeanAndError mean(const std::vector<double>& values) {
  MeanAndError out;
  const auto n = static_cast<double>(values.size());
  for (const double v : values) out.value += v / n;
  for (const double v : values) out.error += std::pow(v - out.value, 2);
  out.error = std::sqrt(out.error / (n * (n - 1)));
  return out;
}
MeanAndError mean_difference(std::vector<double> a, const std::vector<double>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
  return mean(a);
}

// Losses of the candidates by point, the first without smoothing. The search ends where the loss
// has risen for sure.
std::vector<std::vector<double>> try_strengths(const std::vector<Fold>& folds,
                                               const PointMeans& means, FitLoss loss,
                                               std::vector<SmoothingEvidence>& evidence) {
  std::vector<Controls> u;
  for (const Fold& fold : folds) u.push_back(fold.quadratic.centre);
  std::vector<std::vector<double>> losses;
  std::size_t best = 0;
  for (double strength = 0; strength <= kMaxStrength;
       strength = strength > 0 ? kStep * strength : kMinStrength) {
    if (strength > 0)
      for (std::size_t f = 0; f < folds.size(); ++f)
        u[f] = bounded_minimum(folds[f].quadratic, strength, u[f], kTolerance);
    losses.push_back(means.of(folds, [&](std::size_t f, const Unseen& row) {
      const double predicted = row.force.dot(u[f].row(static_cast<Eigen::Index>(row.point)));
      const double z = std::abs(row.weight * (predicted - row.measured));
      return std::pow(loss_factor(loss, 1, z) * z, 2);
    }));
    evidence.push_back({strength, mean(losses.back()).value});
    const std::size_t at = losses.size() - 1;
    if (evidence[at].heldout_loss < evidence[best].heldout_loss) best = at;
    const MeanAndError worse = mean_difference(losses[at], losses[best]);
    if (worse.value > 4 * worse.error && at > best + 1) break;
  }
  return losses;
}

// Median standard error of the curves at their ends, over the force there, but for what they have
// in common.
double typical_error(const SmoothingData& data) {
  std::vector<double> errors;
  for (Eigen::Index p = 0; p < data.estimate.rows(); ++p) {
    const Eigen::VectorXd unit = data.unit.row(p);
    const double force = data.estimate.row(p).dot(unit);
    const double variance = unit.dot(data.covariance[static_cast<std::size_t>(p)] * unit);
    if (force > 0) errors.push_back(std::sqrt(std::max(variance, 0.0)) / force);
  }
  const double own_share = make_quadratic(data.estimate, data.covariance, data.edges).own_share;
  return std::sqrt(own_share) * median(std::move(errors));
}

}  // namespace

void choose_smoothing(const SmoothingData& data, FitLoss loss, SmoothingReport& report) {
  if (data.estimate.rows() < kFewestPoints || data.edges.empty()) {
    report.reason = "too few neighbours to judge";
    return;
  }
  if (typical_error(data) < kExact) {
    report.reason = "neighbours scatter by less than " + percent(kExact) + " of force";
    return;
  }
  const std::vector<Fold> folds = make_folds(data, loss);
  const PointMeans means(folds, data.rows.size());
  if (means.points() < static_cast<std::size_t>(kFewestPoints)) {
    report.reason = "too few points have rows to hold out";
    return;
  }
  const auto losses = try_strengths(folds, means, loss, report.evidence);
  const double own =
      mean(means.of(folds, [&](std::size_t f, const Unseen& row) {
        const auto& precision = folds[f].quadratic.precision[row.point];
        return row.weight * row.weight * row.force.dot(precision.llt().solve(row.force));
      })).value;
  std::size_t best = 0, chosen = 0;
  for (std::size_t i = 1; i < losses.size(); ++i)
    if (report.evidence[i].heldout_loss < report.evidence[best].heldout_loss) best = i;
  while (chosen < best) {
    const MeanAndError worse = mean_difference(losses[chosen], losses[best]);
    if (worse.value <= worse.error) break;
    ++chosen;
  }
  const MeanAndError gain = mean_difference(losses.front(), losses[chosen]);
  report.gain = gain.value / own;
  report.gain_error = gain.error / own;
  if (chosen == 0) {
    report.reason = "rows not seen are predicted no better with neighbours";
  } else if (report.gain < kMinGain) {
    report.reason = "only " + percent(report.gain) + " of the curves' own error would be gained";
  } else if (report.gain - 2 * report.gain_error > 1) {
    report.reason = "rows not seen gain " + percent(report.gain) +
                    " of the curves' own error: they are off by more than noise";
  } else {
    report.strength = report.evidence[chosen].strength;
    report.reason = percent(report.gain) + " +- " + percent(report.gain_error) +
                    " of the curves' own error is gained on rows not seen";
  }
}

}  // namespace palpate::fit
