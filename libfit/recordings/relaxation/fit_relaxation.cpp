#include "libfit/recordings/relaxation/fit_relaxation.hpp"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "libfit/core/statistics.hpp"
#include "libfit/recordings/relaxation/bed_response.hpp"

namespace palpate::recordings {
namespace {

constexpr double kMinShare = 1e-3;  // nobody feels less
constexpr double kMostShare = 100;  // of a search
constexpr double kStep = 1e-5;      // of the difference quotients, in logarithms and deviations
constexpr int kTimes = 8;           // of trial branches
constexpr std::array<double, 4> kShares{0.1, 0.3, 1, 3};
constexpr int kFolds = 5;
constexpr int kIterations = 40, kTrialIterations = 6;
constexpr int kHeldOutIterations = 3;  // from the solution with all rows
constexpr double kNear = 0.02;         // in the logarithm, to a bound
constexpr double k95 = 1.96;
constexpr double kMaxCorrelation = 0.98;
constexpr double kToldShare = 0.5;  // deviation of the logarithm of a share that is told

// Logarithms of shares, then of times; shifts of each group.
struct Values {
  std::vector<double> branch;
  std::vector<std::vector<double>> shift;

  Relaxation relaxation() const {
    const auto n = static_cast<Eigen::Index>(branch.size() / 2);
    const Eigen::Map<const Eigen::VectorXd> all(branch.data(), 2 * n);
    return {all.head(n).array().exp(), all.tail(n).array().exp()};
  }
};

Relaxation relaxation_of(const double* branch, int branches) {
  const Eigen::Map<const Eigen::VectorXd> all(branch, 2 * branches);
  return {all.head(branches).array().exp(), all.tail(branches).array().exp()};
}

// Residuals of one group; those held out are none.
class GroupResiduals final : public ceres::CostFunction {
 public:
  GroupResiduals(const PressGroup& group, int branches, const std::vector<char>& held_out)
      : group_(group), branches_(branches), held_out_(held_out) {
    set_num_residuals(static_cast<int>(group.residuals()));
    if (branches > 0) mutable_parameter_block_sizes()->push_back(2 * branches);
    if (group.shifts() > 0)
      mutable_parameter_block_sizes()->push_back(static_cast<int>(group.shifts()));
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const std::size_t blocks = parameter_block_sizes().size();
    std::vector<std::vector<double>> at;
    for (std::size_t b = 0; b < blocks; ++b)
      at.emplace_back(parameters[b], parameters[b] + parameter_block_sizes()[b]);
    Eigen::Map<Eigen::VectorXd>(residuals, num_residuals()) = value(at);
    if (!jacobians) return true;
    for (std::size_t b = 0; b < blocks; ++b) {
      if (!jacobians[b]) continue;
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> jacobian(
          jacobians[b], num_residuals(), static_cast<Eigen::Index>(at[b].size()));
      for (std::size_t k = 0; k < at[b].size(); ++k) {
        const double here = at[b][k];
        at[b][k] = here + kStep;
        jacobian.col(static_cast<Eigen::Index>(k)) =
            (value(at) - Eigen::Map<const Eigen::VectorXd>(residuals, num_residuals())) / kStep;
        at[b][k] = here;
      }
    }
    return true;
  }

 private:
  Eigen::VectorXd value(const std::vector<std::vector<double>>& at) const {
    const Relaxation relaxation =
        branches_ > 0 ? relaxation_of(at[0].data(), branches_) : Relaxation{};
    const double* shifts = group_.shifts() > 0 ? at.back().data() : nullptr;
    Eigen::VectorXd left = group_.solve(relaxation, shifts, held_out_).residual;
    for (Eigen::Index i = 0; i < group_.rows(); ++i)
      if (held_out_[static_cast<std::size_t>(i)]) left[i] = 0;
    return left;
  }

  const PressGroup& group_;
  int branches_;
  const std::vector<char>& held_out_;
};

class SeriesSearch {
 public:
  SeriesSearch(const std::vector<std::vector<RelaxingPress>>& points, SlowCurve curve,
               double shortest_s, double longest_s)
      : low_(std::log(shortest_s)), high_(std::log(longest_s)) {
    for (const auto& presses : points) groups_.emplace_back(presses, curve);
    for (const PressGroup& group : groups_)
      none_.emplace_back(static_cast<std::size_t>(group.rows()), 0);
  }
  const std::vector<PressGroup>& groups() const { return groups_; }
  double low() const { return low_; }
  double high() const { return high_; }

  Values start() const {
    Values values;
    for (const PressGroup& group : groups_)
      values.shift.emplace_back(static_cast<std::size_t>(group.shifts()), 0.);
    return values;
  }

  double squares(const Values& values) const {
    double sum = 0;
    for (std::size_t g = 0; g < groups_.size(); ++g)
      sum += groups_[g]
                 .solve(values.relaxation(), values.shift[g].data(), none_[g])
                 .residual.squaredNorm();
    return sum;
  }

  Values refined(Values values, const std::vector<std::vector<char>>& held_out,
                 int iterations) const {
    const int branches = static_cast<int>(values.branch.size() / 2);
    ceres::Problem problem;
    bool has_unknowns = branches > 0;
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      std::vector<double*> blocks;
      if (branches > 0) blocks.push_back(values.branch.data());
      if (groups_[g].shifts() > 0) blocks.push_back(values.shift[g].data());
      if (blocks.empty()) continue;
      has_unknowns = true;
      problem.AddResidualBlock(new GroupResiduals(groups_[g], branches, held_out[g]), nullptr,
                               blocks);
      for (Eigen::Index s = 0; s < groups_[g].shifts(); ++s) {
        problem.SetParameterLowerBound(values.shift[g].data(), static_cast<int>(s), -4);
        problem.SetParameterUpperBound(values.shift[g].data(), static_cast<int>(s), 4);
      }
    }
    if (!has_unknowns) return values;
    for (int k = 0; k < branches; ++k) {
      problem.SetParameterLowerBound(values.branch.data(), k, std::log(kMinShare));
      problem.SetParameterUpperBound(values.branch.data(), k, std::log(kMostShare));
      problem.SetParameterLowerBound(values.branch.data(), branches + k, low_);
      problem.SetParameterUpperBound(values.branch.data(), branches + k, high_);
    }
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.function_tolerance = 1e-7, options.parameter_tolerance = 1e-6;
    options.max_num_iterations = iterations;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    return values;
  }
  Values refined(Values values) const { return refined(std::move(values), none_, kIterations); }

  // With one branch more: the best of a grid of trial branches, refined.
  Values with_another(const Values& from) const {
    std::vector<std::pair<double, Values>> trials;
    for (int t = 0; t < kTimes; ++t)
      for (const double share : kShares) {
        Values trial = from;
        const auto n = static_cast<std::ptrdiff_t>(trial.branch.size() / 2);
        trial.branch.insert(trial.branch.begin() + n, std::log(share));
        trial.branch.push_back(low_ + (high_ - low_) * (t + 0.5) / kTimes);
        trials.emplace_back(squares(trial), std::move(trial));
      }
    std::ranges::stable_sort(trials, {}, &std::pair<double, Values>::first);
    // The second start is of another time.
    Values best = refined(trials[0].second, none_, kTrialIterations);
    const auto other = std::ranges::find_if(trials, [&](const auto& trial) {
      return std::abs(trial.second.branch.back() - trials[0].second.branch.back()) > 1e-9;
    });
    Values second = refined(other->second, none_, kTrialIterations);
    return refined(squares(second) < squares(best) ? second : best);
  }

  // Mean square of what was left of each stretch by a fit that did not see it; without iterations
  // it saw the stretch for the branches, but not for curve and sensor.
  std::vector<double> held_out_squares(const Values& found, int iterations) const {
    std::vector<double> out;
    std::vector<std::size_t> offset;
    for (const PressGroup& group : groups_) {
      offset.push_back(out.size());
      out.resize(out.size() + static_cast<std::size_t>(group.stretches()), 0);
    }
    std::vector<double> count(out.size(), 0);
    for (int fold = 0; fold < kFolds; ++fold) {
      std::vector<std::vector<char>> held_out = none_;
      for (std::size_t g = 0; g < groups_.size(); ++g)
        for (std::size_t i = 0; i < held_out[g].size(); ++i)
          held_out[g][i] = groups_[g].stretch()[i] >= 0 && groups_[g].stretch()[i] % kFolds == fold;
      const Values values = iterations > 0 ? refined(found, held_out, iterations) : found;
      for (std::size_t g = 0; g < groups_.size(); ++g) {
        const auto solution =
            groups_[g].solve(values.relaxation(), values.shift[g].data(), held_out[g]);
        for (std::size_t i = 0; i < held_out[g].size(); ++i) {
          if (!held_out[g][i]) continue;
          const std::size_t at = offset[g] + static_cast<std::size_t>(groups_[g].stretch()[i]);
          const double left = solution.residual[static_cast<Eigen::Index>(i)];
          out[at] += left * left, count[at] += 1;
        }
      }
    }
    for (std::size_t s = 0; s < out.size(); ++s) out[s] /= std::max(1., count[s]);
    return out;
  }

 private:
  std::vector<PressGroup> groups_;
  std::vector<std::vector<char>> none_;
  double low_, high_;
};

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.) /
         static_cast<double>(std::max<std::size_t>(1, values.size()));
}

// Whether held-out errors fall by more than one standard error of their differences.
bool is_gain(const std::vector<double>& before, const std::vector<double>& after) {
  const auto n = static_cast<double>(before.size());
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const double less = before[i] - after[i];
    sum += less, squares += less * less;
  }
  const double variance = std::max(0., squares - sum * sum / n) / std::max(1., n - 1);
  return sum / n > std::sqrt(variance / n);
}

// Whether rows tell every branch: its share, and that its time is above their shortest.
bool is_told(const RelaxationFit& fit) {
  const Eigen::Index branches = fit.relaxation.branches();
  for (Eigen::Index k = 0; k < branches; ++k)
    if (fit.is_faster[static_cast<std::size_t>(k)] ||
        !(fit.covariance(k, k) < kToldShare * kToldShare))
      return false;
  return true;
}

// 1 + 2 (r1 + r2 + ...) of rows that follow each other, until the first that is not positive.
double correlation_rows(const Eigen::VectorXd& left) {
  const double alone = left.squaredNorm();
  const Eigen::Index n = left.size();
  double rows = 1;
  for (Eigen::Index lag = 1; alone > 0 && lag < n / 4; ++lag) {
    const double r = left.head(n - lag).dot(left.tail(n - lag)) / alone;
    if (r < 2 / std::sqrt(static_cast<double>(n))) break;
    rows += 2 * std::min(r, kMaxCorrelation);
  }
  return rows;
}

// Sorts branches by time.
Values sorted(const Values& values) {
  const std::size_t n = values.branch.size() / 2;
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t k) { return values.branch[n + k]; });
  Values out = values;
  for (std::size_t k = 0; k < n; ++k)
    out.branch[k] = values.branch[order[k]], out.branch[n + k] = values.branch[n + order[k]];
  return out;
}

// Covariance, intervals and pictures at the solution.
void describe(const SeriesSearch& with, const std::vector<std::vector<RelaxingPress>>& points,
              const Values& values, RelaxationFit& fit) {
  const auto branches = static_cast<Eigen::Index>(values.branch.size() / 2);
  fit.relaxation = values.relaxation();
  const auto& groups = with.groups();
  Eigen::Index shifts = 0, rows = 0;
  for (const PressGroup& group : groups) shifts += group.shifts(), rows += group.residuals();
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(rows, 2 * branches + shifts);
  Eigen::Index row = 0, column = 2 * branches, used = 0, unknowns = 2 * branches;
  double squares = 0, correlated = 0;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const PressGroup& group = groups[g];
    const std::vector<char> none(static_cast<std::size_t>(group.rows()), 0);
    const GroupResiduals residuals(group, static_cast<int>(branches), none);
    const Eigen::Index n = group.residuals();
    Eigen::VectorXd left(n);
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> by_branch(n,
                                                                                     2 * branches),
        by_shift(n, group.shifts());
    std::vector<const double*> at;
    std::vector<double*> by;
    if (branches > 0) at.push_back(values.branch.data()), by.push_back(by_branch.data());
    if (group.shifts() > 0) at.push_back(values.shift[g].data()), by.push_back(by_shift.data());
    residuals.Evaluate(at.data(), left.data(), by.data());
    jacobian.block(row, 0, n, 2 * branches) = by_branch;
    jacobian.block(row, column, n, group.shifts()) = by_shift;
    row += n, column += group.shifts();
    const auto solution = group.solve(fit.relaxation, values.shift[g].data(), none);
    used += group.rows_used();
    unknowns += solution.unknowns;
    fit.pictures.emplace_back();
    for (std::size_t r = 0; r < group.recordings(); ++r) {
      const TimedPress& p = points[g][r].press;
      std::vector<double> seen;
      for (Eigen::Index i = 0; i < p.rows(); ++i)
        if (p.readings[i] > 0 && left[group.first_row(r) + i] != 0)
          seen.push_back(left[group.first_row(r) + i]);
      const Eigen::Map<const Eigen::VectorXd> in_order(seen.data(),
                                                       static_cast<Eigen::Index>(seen.size()));
      squares += in_order.squaredNorm();
      correlated += in_order.squaredNorm() * correlation_rows(in_order);
      fit.pictures.back().push_back(
          {p.time_s, p.depth_m, p.push_N, solution.fitted_N.segment(group.first_row(r), p.rows())});
    }
  }
  double left_N = 0, readings = 0;
  for (std::size_t g = 0; g < points.size(); ++g)
    for (std::size_t r = 0; r < points[g].size(); ++r) {
      const FittedPress& p = fit.pictures[g][r];
      for (Eigen::Index i = 0; i < p.time_s.size(); ++i)
        if (points[g][r].press.readings[i] > 0 && p.depth_m[i] > 0)
          left_N += (p.push_N[i] - p.fitted_N[i]) * (p.push_N[i] - p.fitted_N[i]), readings += 1;
    }
  fit.rms_N = std::sqrt(left_N / std::max(1., readings));
  if (branches == 0) return;

  std::vector<Eigen::Index> free;
  fit.is_slower.assign(static_cast<std::size_t>(branches), 0);
  fit.is_faster = fit.is_slower;
  for (Eigen::Index k = 0; k < jacobian.cols(); ++k) {
    if (k >= branches && k < 2 * branches) {
      const double at = values.branch[static_cast<std::size_t>(k)];
      const auto branch = static_cast<std::size_t>(k - branches);
      fit.is_slower[branch] = at > with.high() - kNear;
      fit.is_faster[branch] = at < with.low() + kNear;
      if (fit.is_slower[branch] || fit.is_faster[branch]) continue;
    }
    free.push_back(k);
  }
  // Rows that go together count as fewer, also against the unknowns.
  const double together = squares > 0 ? correlated / squares : 1;
  const double independent = static_cast<double>(used) - together * static_cast<double>(unknowns);
  const double scale = std::max(1e-12, correlated / std::max(together, independent));
  Eigen::MatrixXd information = (jacobian.transpose() * jacobian)(free, free) / scale;
  for (std::size_t k = 0; k < free.size(); ++k)  // the priors of shifts do not scale with noise
    if (free[k] >= 2 * branches)
      information(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(k)) += 1 - 1 / scale;
  const auto n = static_cast<Eigen::Index>(free.size());
  const Eigen::MatrixXd inverse = information.ldlt().solve(Eigen::MatrixXd::Identity(n, n));
  fit.covariance = Eigen::MatrixXd::Zero(2 * branches, 2 * branches);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      if (free[static_cast<std::size_t>(i)] < 2 * branches &&
          free[static_cast<std::size_t>(j)] < 2 * branches)
        fit.covariance(free[static_cast<std::size_t>(i)], free[static_cast<std::size_t>(j)]) =
            inverse(i, j);
  const Eigen::VectorXd wide =
      (k95 * fit.covariance.diagonal().cwiseMax(0).cwiseSqrt()).array().exp();
  fit.share_low = fit.relaxation.share.cwiseQuotient(wide.head(branches));
  fit.share_high = fit.relaxation.share.cwiseProduct(wide.head(branches));
  fit.time_low_s = fit.relaxation.time_s.cwiseQuotient(wide.tail(branches));
  fit.time_high_s = fit.relaxation.time_s.cwiseProduct(wide.tail(branches));
  for (std::size_t k = 0; k < fit.is_slower.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    if (fit.is_slower[k]) fit.time_high_s[i] = std::numeric_limits<double>::infinity();
    if (fit.is_faster[k]) fit.time_low_s[i] = 0;
  }
}

}  // namespace

RelaxationFit::Band RelaxationFit::band(const Eigen::VectorXd& time_s) const {
  Band out;
  out.middle = stiffening(relaxation, time_s);
  out.low = out.high = out.middle;
  const Eigen::Index branches = relaxation.branches();
  for (Eigen::Index i = 0; i < time_s.size(); ++i) {
    Eigen::VectorXd by(2 * branches);  // of psi, by the logarithms of shares and times
    for (Eigen::Index k = 0; k < branches; ++k) {
      const double ago = time_s[i] / relaxation.time_s[k];
      by[k] = relaxation.share[k] * std::exp(-ago);
      by[branches + k] = by[k] * ago;
    }
    const double deviation = branches > 0 ? std::sqrt(std::max(0., by.dot(covariance * by))) : 0;
    out.low[i] = std::max(1., out.middle[i] - k95 * deviation);
    out.high[i] = out.middle[i] + k95 * deviation;
  }
  return out;
}

RelaxationFit fit_relaxation(const std::vector<std::vector<RelaxingPress>>& points, int exactly) {
  RelaxationFit fit;
  std::vector<double> steps;
  for (const auto& presses : points)
    for (const RelaxingPress& one : presses) {
      double from_s = std::numeric_limits<double>::infinity(), to_s = 0;
      for (Eigen::Index i = 1; i < one.press.rows(); ++i) {
        if (!(one.press.depth_m[i] > 0)) continue;
        steps.push_back(one.press.time_s[i] - one.press.time_s[i - 1]);
        from_s = std::min(from_s, one.press.time_s[i - 1]), to_s = one.press.time_s[i];
      }
      fit.longest_s = std::max(fit.longest_s, to_s - from_s);
    }
  if (steps.empty() || !(fit.longest_s > 0)) return fit;
  fit.shortest_s = std::min(2 * median(steps), fit.longest_s / 4);
  fit.shortest_s = std::max(fit.shortest_s, runtime::kMinRelaxation_s);
  fit.longest_s = std::clamp(fit.longest_s, 4 * fit.shortest_s, runtime::kMaxRelaxation_s);

  const SeriesSearch powers(points, SlowCurve::powers, fit.shortest_s, fit.longest_s),
      free(points, SlowCurve::free, fit.shortest_s, fit.longest_s);
  const Values none = powers.refined(powers.start()), one = powers.with_another(none),
               other = free.refined(one);
  const bool is_free =
      mean(free.held_out_squares(other, 0)) < mean(powers.held_out_squares(one, 0));
  const SeriesSearch& with = is_free ? free : powers;
  fit.curve = is_free ? SlowCurve::free : SlowCurve::powers;

  const auto described = [&](const Values& values) {
    RelaxationFit out = fit;
    describe(with, points, sorted(values), out);
    return out;
  };
  Values found = is_free ? free.refined(free.start()) : none;
  RelaxationFit best = described(found);
  std::vector<double> before = with.held_out_squares(found, kHeldOutIterations);
  std::vector<double> held_out{std::sqrt(mean(before))};
  for (int branches = 1; branches <= (exactly < 0 ? runtime::kMaxBranches : exactly); ++branches) {
    const Values next = branches > 1 ? with.with_another(found) : is_free ? other : one;
    RelaxationFit more = described(next);
    if (exactly < 0) {
      const std::vector<double> errors = with.held_out_squares(next, kHeldOutIterations);
      held_out.push_back(std::sqrt(mean(errors)));
      if (!is_gain(before, errors) || !is_told(more)) break;
      before = errors;
    }
    found = next, best = std::move(more);
  }
  best.held_out = held_out;
  return best;
}

}  // namespace palpate::recordings
