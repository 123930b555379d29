#include "libfit/recordings/relaxation/fit_relaxation.hpp"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>

#include "libfit/core/linear_algebra.hpp"

namespace palpate::recordings {
namespace {

constexpr double kStep = 1e-5;  // of the difference quotients, in logarithms and deviations
constexpr int kTimes = 8;       // of trial branches
constexpr std::array<double, 4> kShares{0.1, 0.3, 1, 3};
constexpr int kFolds = 5;
constexpr int kIterations = 40, kTrialIterations = 6;

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

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
    const int of_shifts = branches_ > 0 ? 1 : 0;  // its block
    std::vector<double> branch(parameters[0], parameters[0] + 2 * branches_), shift;
    if (group_.shifts() > 0)
      shift.assign(parameters[of_shifts], parameters[of_shifts] + group_.shifts());
    const Relaxation here = relaxation_of(branch.data(), branches_);
    const Eigen::MatrixXd parts = group_.parts(here, shift.data());
    const Eigen::VectorXd left = value(parts, shift);
    Eigen::Map<Eigen::VectorXd>(residuals, num_residuals()) = left;
    if (!jacobians) return true;
    if (branches_ > 0 && jacobians[0]) {
      Eigen::Map<RowMajor> jacobian(jacobians[0], num_residuals(), 2 * branches_);
      for (std::size_t k = 0; k < branch.size(); ++k) {
        std::vector<double> moved = branch;
        moved[k] += kStep;
        const Relaxation there = relaxation_of(moved.data(), branches_);
        jacobian.col(k) = (value(group_.parts(there, shift.data()), shift) - left) / kStep;
      }
    }
    if (group_.shifts() == 0 || !jacobians[of_shifts]) return true;
    Eigen::Map<RowMajor> jacobian(jacobians[of_shifts], num_residuals(), group_.shifts());
    for (std::size_t r = 0; r < group_.recordings(); ++r) {
      if (group_.shift_of(r) < 0) continue;
      std::vector<double> moved = shift;
      moved[group_.shift_of(r)] += kStep;
      Eigen::MatrixXd other = parts;
      group_.put_parts(r, here, moved.data(), other);
      jacobian.col(group_.shift_of(r)) = (value(other, moved) - left) / kStep;
    }
    return true;
  }

 private:
  Eigen::VectorXd value(const Eigen::MatrixXd& parts, const std::vector<double>& shift) const {
    Eigen::VectorXd left = group_.solve(parts, shift.data(), held_out_).residual;
    for (Eigen::Index i = 0; i < group_.rows(); ++i)
      if (held_out_[i]) left[i] = 0;
    return left;
  }

  const PressGroup& group_;
  int branches_;
  const std::vector<char>& held_out_;
};

// Variances of drift over that of the noise of rows.
constexpr std::array<double, 10> kProportions{0, 0.03, 0.1, 0.3, 1, 3, 10, 30, 100, 300};

// Correlation of noise whose power goes as 1/f between the spacing of rows and their length.
Eigen::MatrixXd slow_correlation(const Eigen::VectorXd& time_s) {
  const Eigen::Index n = time_s.size();
  const double length_s = time_s[n - 1] - time_s[0];
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(n, n);
  double terms = 0;
  for (double s = length_s / static_cast<double>(n); s <= length_s; s *= 3, ++terms)
    sum.array() +=
        (-(time_s.replicate(1, n).rowwise() - time_s.transpose()).array().abs() / s).exp();
  return sum / terms;
}

}  // namespace

Relaxation SeriesValues::relaxation() const {
  return relaxation_of(branch.data(), static_cast<int>(branches()));
}

SeriesSearch::SeriesSearch(const std::vector<std::vector<TimedPress>>& points, SlowCurve curve,
                           double shortest_s, double longest_s)
    : low_(std::log(shortest_s)), high_(std::log(longest_s)) {
  for (const auto& presses : points) groups_.emplace_back(presses, curve);
  for (const PressGroup& group : groups_) none_.emplace_back(group.rows(), 0);
}

SeriesValues SeriesSearch::start() const {
  SeriesValues values;
  for (const PressGroup& group : groups_) values.shift.emplace_back(group.shifts(), 0.);
  return values;
}

double SeriesSearch::squares(const SeriesValues& values) const {
  double sum = 0;
  for (std::size_t g = 0; g < groups_.size(); ++g)
    sum += solution(g, values).residual.squaredNorm();
  return sum;
}

SeriesValues SeriesSearch::refined(SeriesValues values, const HeldOut& held_out,
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
    problem.SetParameterLowerBound(values.branch.data(), k, std::log(1e-3));
    problem.SetParameterUpperBound(values.branch.data(), k, std::log(100.));
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
SeriesValues SeriesSearch::refined(const SeriesValues& values) const {
  return refined(values, none_, kIterations);
}

SeriesValues SeriesSearch::with_another(const SeriesValues& from) const {
  std::vector<std::pair<double, SeriesValues>> trials;
  for (int t = 0; t < kTimes; ++t)
    for (const double share : kShares) {
      SeriesValues trial = from;
      const auto n = static_cast<std::ptrdiff_t>(trial.branch.size() / 2);
      trial.branch.insert(trial.branch.begin() + n, std::log(share));
      trial.branch.push_back(low_ + (high_ - low_) * (t + 0.5) / kTimes);
      trials.emplace_back(squares(trial), std::move(trial));
    }
  std::ranges::stable_sort(trials, {}, &std::pair<double, SeriesValues>::first);
  // The second start is of another time.
  SeriesValues best = refined(trials[0].second, none_, kTrialIterations);
  const auto other = std::ranges::find_if(trials, [&](const auto& trial) {
    return std::abs(trial.second.branch.back() - trials[0].second.branch.back()) > 1e-9;
  });
  SeriesValues second = refined(other->second, none_, kTrialIterations);
  return refined(squares(second) < squares(best) ? second : best);
}

std::vector<double> SeriesSearch::held_out_squares(const SeriesValues& found,
                                                   int iterations) const {
  std::vector<double> out;
  std::vector<std::size_t> offset;
  for (const PressGroup& group : groups_) {
    offset.push_back(out.size());
    out.resize(out.size() + static_cast<std::size_t>(group.stretches()), 0);
  }
  std::vector<double> count(out.size(), 0);
  for (int fold = 0; fold < kFolds; ++fold) {
    HeldOut held_out = none_;
    for (std::size_t g = 0; g < groups_.size(); ++g)
      for (std::size_t i = 0; i < held_out[g].size(); ++i)
        held_out[g][i] = groups_[g].stretch()[i] >= 0 && groups_[g].stretch()[i] % kFolds == fold;
    const SeriesValues values = iterations > 0 ? refined(found, held_out, iterations) : found;
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      const double* shift = values.shift[g].data();
      const auto solution =
          groups_[g].solve(groups_[g].parts(values.relaxation(), shift), shift, held_out[g]);
      for (std::size_t i = 0; i < held_out[g].size(); ++i) {
        if (!held_out[g][i]) continue;
        const std::size_t at = offset[g] + static_cast<std::size_t>(groups_[g].stretch()[i]);
        const double left = solution.residual[i];
        out[at] += left * left, count[at] += 1;
      }
    }
  }
  for (std::size_t s = 0; s < out.size(); ++s) out[s] /= std::max(1., count[s]);
  return out;
}

SeriesSearch::Slopes SeriesSearch::slopes(std::size_t group, const SeriesValues& values) const {
  const GroupResiduals residuals(groups_[group], static_cast<int>(values.branches()), none_[group]);
  const Eigen::Index n = groups_[group].residuals(), shifts = groups_[group].shifts();
  Eigen::VectorXd left(n);
  RowMajor by_branch(n, 2 * values.branches()), by_shift(n, shifts);
  std::vector<const double*> at;
  std::vector<double*> by;
  if (values.branches() > 0) at.push_back(values.branch.data()), by.push_back(by_branch.data());
  if (shifts > 0) at.push_back(values.shift[group].data()), by.push_back(by_shift.data());
  residuals.Evaluate(at.data(), left.data(), by.data());
  return {left, by_branch, by_shift};
}

PressGroup::Solution SeriesSearch::solution(std::size_t group, const SeriesValues& values) const {
  const double* shift = values.shift[group].data();
  return groups_[group].solve(groups_[group].parts(values.relaxation(), shift), shift,
                              none_[group]);
}

Eigen::MatrixXd sensor_covariance(const Eigen::VectorXd& time_s, const Eigen::VectorXd& noise,
                                  const Eigen::VectorXd& weight, const Eigen::VectorXd& residual,
                                  const Eigen::MatrixXd& slopes) {
  const Eigen::Index n = residual.size();
  const Eigen::ArrayXd own = noise.array().max(0.1).square();  // no row is better
  if (n < 3) return own.matrix().asDiagonal();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> basis(slopes);
  basis.setThreshold(1e-8);
  const Eigen::Index known = basis.rank();
  const auto left = static_cast<double>(n - known);
  if (left < 2) return own.matrix().asDiagonal();
  const Eigen::MatrixXd q = basis.householderQ() * Eigen::MatrixXd::Identity(n, known);
  const Eigen::MatrixXd drift =
      own.mean() / weight.squaredNorm() * static_cast<double>(n) *
      (weight.asDiagonal() * slow_correlation(time_s) * weight.asDiagonal());

  std::array<double, kProportions.size()> likelihood, scale;
  for (std::size_t k = 0; k < kProportions.size(); ++k) {
    Eigen::MatrixXd all = kProportions[k] * drift;
    all.diagonal().array() += own;
    const Eigen::LLT<Eigen::MatrixXd> factor(all);
    const Eigen::MatrixXd white = factor.matrixL().solve(q);
    const Eigen::VectorXd rest = factor.matrixL().solve(residual);
    const Eigen::LLT<Eigen::MatrixXd> inner(Eigen::MatrixXd(white.transpose() * white));
    const Eigen::VectorXd by = inner.matrixL().solve(white.transpose() * rest);
    scale[k] = std::max(rest.squaredNorm() - by.squaredNorm(), 1e-300) / left;
    likelihood[k] = -factor.matrixLLT().diagonal().array().log().sum() -
                    inner.matrixLLT().diagonal().array().log().sum() -
                    left / 2 * std::log(scale[k]);
  }
  const double most = *std::ranges::max_element(likelihood);
  double sum = 0, diagonal = 0, slow = 0;
  for (std::size_t k = 0; k < kProportions.size(); ++k) {
    const double share = std::exp(likelihood[k] - most);
    sum += share;
    diagonal += share * scale[k], slow += share * scale[k] * kProportions[k];
  }
  Eigen::MatrixXd out = slow / sum * drift;
  out.diagonal().array() += diagonal / sum * own;
  return out;
}

Eigen::MatrixXd series_covariance(const SeriesSearch& with, const SeriesValues& values) {
  const Eigen::Index branches = values.branches();
  Eigen::Index unknowns = 2 * branches;
  for (const PressGroup& group : with.groups()) unknowns += group.shifts();
  std::vector<Eigen::Index> free;
  for (Eigen::Index k = 0; k < unknowns; ++k) {
    if (k >= branches && k < 2 * branches)
      if (const double at = values.branch[k]; with.is_slowest(at) || with.is_fastest(at)) continue;
    free.push_back(k);
  }
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(unknowns, unknowns), noise = information;
  Eigen::Index first = 2 * branches;  // of the group's shifts
  for (std::size_t g = 0; g < with.groups().size(); ++g) {
    const PressGroup& group = with.groups()[g];
    const Eigen::Index shifts = group.shifts();
    const SeriesSearch::Slopes slopes = with.slopes(g, values);
    const Eigen::MatrixXd inner = with.solution(g, values).slopes;
    Eigen::MatrixXd outer = Eigen::MatrixXd::Zero(group.residuals(), unknowns);
    outer.leftCols(2 * branches) = slopes.by_branch;
    outer.middleCols(first, shifts) = slopes.by_shift;
    information += outer.transpose() * outer;
    const Eigen::MatrixXd priors = outer.bottomRows(group.priors());
    noise += priors.transpose() * priors;
    for (std::size_t r = 0; r < group.recordings(); ++r) {
      const PressGroup::FittedRows rows = group.counted(r);
      const Eigen::MatrixXd by = outer(rows.row, Eigen::all);
      Eigen::MatrixXd all(by.rows(), 2 * branches + shifts + inner.cols());
      all << by.leftCols(2 * branches), by.middleCols(first, shifts), inner(rows.row, Eigen::all);
      noise +=
          by.transpose() *
          sensor_covariance(rows.time_s, rows.noise, rows.weight, slopes.residual(rows.row), all) *
          by;
    }
    first += shifts;
  }
  const Eigen::MatrixXd inverse = ldlt_inverse(information(free, free));
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(unknowns, unknowns);
  covariance(free, free) = inverse * noise(free, free) * inverse;
  return covariance;
}

}  // namespace palpate::recordings
