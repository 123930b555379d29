#include "libfem/calibrate/identify.hpp"

#include <ceres/ceres.h>
#include <Eigen/SVD>
#include <algorithm>
#include <unsupported/Eigen/SpecialFunctions>

#include "libfem/calibrate/material_search.hpp"

namespace palpate::fem {
namespace {

using Eigen::Index, Eigen::MatrixXd, Eigen::VectorXd;

constexpr double kUndetermined = 0.5;  // relative deviation of an undetermined parameter

// The 95 % quantile of F with these degrees of freedom.
double f_quantile(double numerator, double denominator) {
  double low = 0, high = 1e6;
  for (int i = 0; i < 100; ++i) {
    const double middle = (low + high) / 2, x = numerator * middle;
    const double below =
        Eigen::numext::betainc(numerator / 2, denominator / 2, x / (x + denominator));
    (below < 0.95 ? low : high) = middle;
  }
  return high;
}

// How many residuals one independent residual stands for: 1 + 2 sum of their correlations over lags
// within experiments, up to the first that is within two of its own errors (M44).
double rows_each(const VectorXd& r, const std::vector<int>& group) {
  const double variance = r.squaredNorm() / r.size();
  double sum = 1;
  for (Index lag = 1; lag < r.size(); ++lag) {
    double products = 0, pairs = 0;
    for (Index i = lag; i < r.size(); ++i)
      if (group[i] == group[i - lag]) {
        products += r[i] * r[i - lag];
        ++pairs;
      }
    const double rho = pairs > 0 && variance > 0 ? products / (pairs * variance) : 0;
    if (!(rho * std::sqrt(pairs) > 2)) break;
    sum += 2 * rho;
  }
  return sum;
}

struct SearchEnd {
  VectorXd y;
  double cost = std::numeric_limits<double>::infinity();
  bool is_converged = false;
};

// Ends where the next step would move the parameters by a tenth of their deviations or less.
class EnoughFound final : public ceres::IterationCallback {
 public:
  explicit EnoughFound(const MaterialSearch& search) : search_(search) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    const double unit = search_.is_stated ? 1 : 2 * summary.cost / search_.num_residuals();
    // A fall of the cost by so few variances ends the search.
    const bool is_enough =
        summary.iteration > 0 && summary.step_is_successful && summary.cost_change < 0.005 * unit;
    return is_enough ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

 private:
  const MaterialSearch& search_;
};

SearchEnd solve(MaterialSearch& search, const MaterialParameters& start) {
  SearchEnd found{search.place(start)};
  ceres::Problem::Options keep;
  keep.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(keep);
  problem.AddResidualBlock(&search, nullptr, found.y.data());
  for (int k = 0; k < search.size(); ++k) {
    const Coordinate& c = search.coordinates[k];
    if (std::isfinite(c.low)) problem.SetParameterLowerBound(found.y.data(), k, c.low);
    if (std::isfinite(c.high)) problem.SetParameterUpperBound(found.y.data(), k, c.high);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 30;
  options.max_num_consecutive_invalid_steps = 30;
  options.initial_trust_region_radius = 1e3;
  options.function_tolerance = 1e-7;
  options.parameter_tolerance = 1e-6;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  EnoughFound enough(search);
  options.callbacks.push_back(&enough);
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (summary.termination_type == ceres::FAILURE) return found;
  found.cost = summary.final_cost;
  found.is_converged = summary.termination_type == ceres::CONVERGENCE ||
                       summary.termination_type == ceres::USER_SUCCESS;
  return found;
}

// Covariance, 95 % region and undetermined parameters (M44), at coordinates y where out.response,
// out.material and out.free are those found. Not converged where a sensitivity has no answer.
void state_errors(const MaterialSearch& search, const Observations& observed, const VectorXd& y,
                  double common_error, Identification& out) {
  const Index k = search.size();
  const std::optional<MatrixXd> J = search.sensitivities(y, out.response);
  if (!J) {
    out.is_converged = false;
    return;
  }
  VectorXd size(k);
  MatrixXd weighted = search.whitened(*J);
  for (Index j = 0; j < k; ++j) {
    size[j] = search.size_of(out.material, j);
    weighted.col(j) *= size[j] / search.coordinates[j].slope(y[j]);
  }
  const VectorXd r = search.whitened(out.response - observed.value);
  out.shared_error = search.shared_error(observed.value - out.response);
  const double n = r.size();
  const double per_freedom = r.squaredNorm() / std::max(1.0, n - k);
  out.misfit = std::sqrt(per_freedom);
  out.sum_of_squares = (out.response - observed.value).squaredNorm();
  double inflation = 1, rows = n;
  if (!search.is_stated || per_freedom > 1) {
    out.rows_each = rows_each(r, observed.group);
    inflation = per_freedom * out.rows_each;
    rows = n / out.rows_each;
  }
  const double freedom = std::max(1.0, rows - k);
  out.region = k * f_quantile(k, freedom);
  out.half_width = std::sqrt(f_quantile(1, freedom));

  const Eigen::JacobiSVD<MatrixXd> svd(weighted, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const VectorXd singular =
      svd.singularValues().cwiseMax(1e-9 * svd.singularValues()[0]).cwiseMax(1e-300);
  const MatrixXd V = svd.matrixV();
  const MatrixXd inverse =
      inflation * V * singular.cwiseAbs2().cwiseInverse().asDiagonal() * V.transpose();
  const VectorXd weighted_response = search.whitened(out.response);
  const VectorXd shared =
      common_error / inflation * inverse * (weighted.transpose() * weighted_response);
  const MatrixXd relative = inverse + shared * shared.transpose();
  out.covariance = size.asDiagonal() * relative * size.asDiagonal();
  const VectorXd deviation = out.covariance.diagonal().cwiseSqrt();
  out.correlation = deviation.cwiseInverse().asDiagonal() * out.covariance *
                    deviation.cwiseInverse().asDiagonal();

  for (Index i = 0; i < k; ++i)
    if (std::sqrt(V.col(i).dot(relative * V.col(i))) > kUndetermined) out.are_told_apart = false;
}

Identification identify_as_stated(const MaterialParameters& start, const Observations& observed,
                                  const MaterialResponses& responses,
                                  const IdentifyOptions& options) {
  MaterialSearch search(start, observed, responses, options);
  Identification out;
  out.material = start;
  out.free = options.free;
  const MaterialParameters middle = search.at(search.place(start).data());
  const VectorXd at_start = responses({middle}).front();
  out.is_stopped = options.progress.stopped();
  if (out.is_stopped || at_start.size() == 0) return out;
  const SearchEnd best = solve(search, search.scaled_to_fit(middle, at_start));
  out.is_stopped = options.progress.stopped();
  if (out.is_stopped || !std::isfinite(best.cost)) return out;
  out.is_converged = best.is_converged;
  out.material = search.at(best.y.data());
  out.response = responses({out.material}).front();
  if (out.response.size() == 0)
    out.is_stopped = true;
  else
    state_errors(search, observed, best.y, options.common_error, out);
  out.is_stopped = options.progress.stopped();
  return out;
}

}  // namespace

std::vector<std::size_t> identifiable(const MaterialParameters& material) {
  std::vector<std::size_t> out;
  std::size_t at = 0;
  for (const ParameterRow& row : find_law(material.law, "law").parameters) {
    if (row.count == 1 && row.name != kPoissonRow.name && row.name != kBulkRow.name &&
        at < material.values.size() && std::isfinite(material.values[at]))
      out.push_back(at);
    at += row.count;
  }
  return out;
}

Identification identify(const MaterialParameters& start, const Observations& observed,
                        const MaterialResponses& responses, const IdentifyOptions& options) {
  Identification out = identify_as_stated(start, observed, responses, options);
  Observations wider = observed;
  double widened = 1;
  for (int k = 0; k < 6 && !out.is_stopped && !out.shared_error.empty(); ++k) {
    const Eigen::Map<const VectorXd> moved(out.shared_error.data(), std::ssize(out.shared_error));
    const double ratio = moved.norm() / std::sqrt(moved.size());
    if (!(ratio > 1.1)) break;  // the stated shared errors are not too small
    widened *= ratio;
    wider.shared *= ratio;
    out = identify_as_stated(out.material, wider, responses, options);
  }
  for (double& error : out.shared_error) error *= widened;
  return out;
}

}  // namespace palpate::fem
