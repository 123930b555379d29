#include "libfit/recordings/indentation/solve_model.hpp"

#include <ceres/ceres.h>
#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "libfit/core/linear_algebra.hpp"
#include "libfit/core/text.hpp"
#include "libfit/recordings/indentation/what_is_left.hpp"

namespace palpate::recordings {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr Eigen::Index kScanRows = 300;  // that trial contact points are compared on
constexpr int kScan = 64;
constexpr double kCloser = 1.25;  // depth of one trial over the next, towards the end
constexpr double kMisfit = 0.05;  // of the force: a model that leaves more does not describe it
constexpr double kLeastExponent = 0.7, kMostExponent = 6;
constexpr Eigen::Index kLeastPressed = 3;

// The shape of the curve at a scaled depth, 1 at about full depth; by depth and by exponent.
struct ShapeValue {
  double value = 0, by_depth = 0, by_exponent = 0;
};

ShapeValue shape(const ModelProblem& p, double depth, double exponent) {
  if (!(depth > 0)) return {};
  if (p.law) {
    const ModelForce f = p.law(depth * p.range_m);
    return {f.area_m2 / p.area_scale, f.slope_m * p.range_m / p.area_scale, 0};
  }
  const double value = std::pow(depth, exponent);
  return {value, exponent * value / depth, value * std::log(depth)};
}

// Least squares in what is linear, at one contact point and exponent; every `stride`th row.
double linear_squares(const ModelProblem& p, double at, double exponent, Eigen::Index stride,
                      Vec3& found) {
  Mat3 normal = Mat3::Identity();
  const Eigen::Index n = p.has_slope ? 3 : 2;
  normal.topLeftCorner(n, n).setZero();
  Vec3 right = Vec3::Zero();
  double all = 0;
  Eigen::Index pressed = 0;
  for (Eigen::Index i = 0; i < p.x.size(); i += stride) {
    const double s = shape(p, p.x[i] - at, exponent).value;
    if (!std::isfinite(s)) return kInfinity;
    const Vec3 row(s, 1, p.x[i]);
    normal.topLeftCorner(n, n) += row.head(n) * row.head(n).transpose();
    right.head(n) += p.y[i] * row.head(n);
    all += p.y[i] * p.y[i];
    pressed += s > 0;
  }
  if (pressed < kLeastPressed) return kInfinity;
  found = normal.ldlt().solve(right);
  return found[0] > 0 ? all - right.dot(found) : kInfinity;
}

// All unknowns: contact, exponent, amplitude, level, slope.
using Unknowns = Eigen::Matrix<double, 5, 1>;

class Residuals final : public ceres::CostFunction {
 public:
  explicit Residuals(const ModelProblem& problem) : problem_(problem) {
    set_num_residuals(static_cast<int>(problem.x.size()));
    mutable_parameter_block_sizes()->push_back(5);
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const double* u = parameters[0];
    double* const jacobian = jacobians ? jacobians[0] : nullptr;
    for (Eigen::Index i = 0; i < problem_.x.size(); ++i) {
      const auto s = shape(problem_, problem_.x[i] - u[0], u[1]);
      if (!std::isfinite(s.value)) return false;
      residuals[i] = u[2] * s.value + u[3] + u[4] * problem_.x[i] - problem_.y[i];
      if (!jacobian) continue;
      double* row = jacobian + 5 * i;
      row[0] = -u[2] * s.by_depth, row[1] = u[2] * s.by_exponent, row[2] = s.value;
      row[3] = 1, row[4] = problem_.x[i];
    }
    return true;
  }

 private:
  const ModelProblem& problem_;
};

// Unknowns to start from: the best of trial contact points that lie denser towards the end, since a
// press may be a small part of the travel.
std::optional<Unknowns> start_of(const ModelProblem& p) {
  const Eigen::Index stride = std::max<Eigen::Index>(1, p.x.size() / kScanRows);
  std::vector<double> trial;
  if (p.contact) {
    trial.push_back(*p.contact);
  } else {
    for (int k = 0; k < kScan; ++k) trial.push_back(-0.5 + 1.5 * k / kScan);
    for (double depth = 0.05; depth > 2. / static_cast<double>(p.x.size()); depth /= kCloser)
      trial.push_back(1 - depth);
  }
  std::vector<double> exponents{1.5};
  if (!p.law) exponents = {1, 1.5, 2, 3};
  Unknowns best = Unknowns::Zero();
  double least = kInfinity;
  // A small press has few of every so many rows: then all count.
  for (const Eigen::Index step : {stride, Eigen::Index{1}}) {
    for (const double contact : trial)
      for (const double exponent : exponents) {
        if (step == 1 && stride > 1 && contact < 0.9) continue;
        Vec3 found = Vec3::Zero();
        const double squares =
            linear_squares(p, contact, exponent, step, found) * static_cast<double>(step);
        if (squares < least) {
          least = squares;
          best << contact, exponent, found[0], found[1], p.has_slope ? found[2] : 0;
        }
      }
    if (stride == 1) break;
  }
  if (!std::isfinite(least)) return std::nullopt;
  return best;
}

// Of the unknowns: contact and exponent where they are known, slope where none is asked for.
std::vector<int> fixed_of(const ModelProblem& p) {
  std::vector<int> fixed;
  if (p.contact) fixed.push_back(0);
  if (p.law) fixed.push_back(1);
  if (!p.has_slope) fixed.push_back(4);
  return fixed;
}

std::optional<Unknowns> minimised(const ModelProblem& p, const std::vector<int>& fixed) {
  auto u = start_of(p);
  if (!u) return std::nullopt;
  ceres::Problem problem;
  problem.AddResidualBlock(new Residuals(p), nullptr, u->data());
  problem.SetManifold(u->data(), new ceres::SubsetManifold(5, fixed));
  if (!p.law) {
    problem.SetParameterLowerBound(u->data(), 1, kLeastExponent);
    problem.SetParameterUpperBound(u->data(), 1, kMostExponent);
  }
  problem.SetParameterLowerBound(u->data(), 0, -3);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.function_tolerance = options.parameter_tolerance = 1e-12;
  options.max_num_iterations = 200;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable() || !((*u)[2] > 0)) return std::nullopt;
  return u;
}

// Of the unknowns, 0 of fixed ones: by rows that go together, or by the sensor's drift where that
// is more. jacobian: W x 5.
Unknowns deviations_of(const Eigen::MatrixXd& jacobian, const std::vector<int>& fixed,
                       const Eigen::VectorXd& left, double correlation_time) {
  std::vector<Eigen::Index> free;
  for (int k = 0; k < 5; ++k)
    if (std::ranges::find(fixed, k) == fixed.end()) free.push_back(k);
  const Eigen::MatrixXd columns = jacobian(Eigen::all, free);
  const Eigen::Index unknowns = columns.cols();
  const double variance =
      left.squaredNorm() / static_cast<double>(left.size() - unknowns) * correlation_time;
  const Eigen::MatrixXd covariance = ldlt_inverse(columns.transpose() * columns) * variance,
                        drifting = covariance_of(columns, left);
  Unknowns out = Unknowns::Zero();
  for (Eigen::Index k = 0; k < unknowns; ++k)
    out[free[static_cast<std::size_t>(k)]] =
        std::sqrt(std::max({0., covariance(k, k), drifting(k, k)}));
  return out;
}

// Says how far the model describes the curve and holds at its depth. left: W, in rises.
void judge(const ModelProblem& p, const Eigen::VectorXd& left, double contact, double most_m,
           ModelFit& fit) {
  const PartMeans parts = part_means(p.x, left, contact, p.x.maxCoeff());
  fit.misfit_N = misfit_of(parts, noise_variance(left)) * p.rise_N;
  fit.has_pattern = has_pattern(p.x, left, contact, fit.force_N / p.rise_N);
  if (fit.misfit_N > kMisfit * fit.force_N)
    add_sentence(fit.remark, "the model does not describe the curve: it is off by " +
                                 percent(fit.misfit_N / fit.force_N) + " of the force");
  else if (fit.has_pattern)
    add_sentence(
        fit.remark,
        fmt::format("what the model leaves goes with depth: {} of the force, of one sign in "
                    "{} runs over {} parts",
                    percent(parts.rms() * p.rise_N / fit.force_N), parts.runs(), kParts));
  fit.is_beyond = fit.depth_m > most_m;
  if (fit.is_beyond)
    add_sentence(fit.remark, fmt::format("deeper than the model holds to 1 % ({:.3g} of {:.3g} um)",
                                         1e6 * most_m, 1e6 * fit.depth_m));
  if (fit.contact_m < p.first_m) add_sentence(fit.remark, "its contact lies before the first row");
}

}  // namespace

std::optional<SolvedModel> solve_model(const ModelProblem& p, const IndentationModel& model,
                                       const Indentation& press) {
  const std::vector<int> fixed = fixed_of(p);
  const auto minimum = minimised(p, fixed);
  if (!minimum) return std::nullopt;
  const Unknowns& u = *minimum;
  const Eigen::Index n = p.x.size();
  Eigen::VectorXd left(n);
  Eigen::Matrix<double, Eigen::Dynamic, 5, Eigen::RowMajor> all(n, 5);
  double* jacobian = all.data();
  const double* at = u.data();
  if (!Residuals(p).Evaluate(&at, left.data(), &jacobian)) return std::nullopt;
  SolvedModel out;
  out.unknowns = 5 - static_cast<Eigen::Index>(fixed.size());
  out.squares = left.squaredNorm();
  out.correlation_time = correlation_time(left);
  const Unknowns deviation = deviations_of(all, fixed, left, out.correlation_time);
  ModelFit& fit = out.fit;
  fit.model = &model;
  fit.contact_m = p.first_m + u[0] * p.range_m;
  fit.contact_deviation_m = deviation[0] * p.range_m;
  fit.baseline_N = p.base_N + (u[3] + u[4] * u[0]) * p.rise_N;
  fit.slope_N_m = u[4] * p.rise_N / p.range_m;
  fit.depth_m = (p.x.maxCoeff() - u[0]) * p.range_m;
  fit.force_N = u[2] * shape(p, p.x.maxCoeff() - u[0], u[1]).value * p.rise_N;
  const double per_young = (1 - press.poisson * press.poisson) * p.rise_N / p.area_scale;
  fit.young_Pa = p.law ? u[2] * per_young : kNan;
  fit.young_deviation_Pa = p.law ? deviation[2] * per_young : kNan;
  if (!p.law) fit.exponent = u[1], fit.exponent_deviation = deviation[1];
  fit.rms_N = std::sqrt(out.squares / static_cast<double>(n)) * p.rise_N;
  judge(p, left, u[0], model.valid_to_m(press), fit);
  return out;
}

}  // namespace palpate::recordings
