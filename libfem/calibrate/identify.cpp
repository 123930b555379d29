#include "libfem/calibrate/identify.hpp"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "libfem/calibrate/material_search.hpp"

namespace palpate::fem {
namespace {

using Eigen::Index, Eigen::VectorXd;

constexpr double kEnough = 0.005;  // fall of the cost that ends a search, in variances
constexpr double kTooSmall = 1.1;  // shared errors over the stated ones, rms: these are too small

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
    const bool is_enough =
        summary.iteration > 0 && summary.step_is_successful && summary.cost_change < kEnough * unit;
    return is_enough ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

 private:
  const MaterialSearch& search_;
};

SearchEnd solve(MaterialSearch& search, const MaterialParameters& start, int max_iterations) {
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
  options.max_num_iterations = max_iterations;
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

// Other moduli and exponents than those of the start, about it.
MaterialParameters scattered(const MaterialSearch& search, MaterialParameters material,
                             unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1.5, 1.5);
  for (int attempt = 0; attempt < 50; ++attempt) {
    MaterialParameters other = material;
    for (const Coordinate& c : search.coordinates)
      other.values[c.index] *= std::exp(uniform(random));
    if (!search.is_refused(other)) return other;
  }
  return material;
}

Identification identify_as_stated(const MaterialParameters& start, const Observations& observed,
                                  const MaterialResponses& responses,
                                  const IdentifyOptions& options) {
  MaterialSearch search(start, observed, responses, options);
  Identification out;
  out.material = start;
  out.free = options.free;
  const MaterialParameters middle = search.at(search.place(start).data());
  SearchEnd best;
  for (int i = 0; i < std::max(1, options.starts) && !options.progress.stopped(); ++i) {
    MaterialParameters from = i == 0 ? middle : scattered(search, middle, i);
    const VectorXd response = responses({from}).front();
    if (response.size() == 0) continue;
    out.has_answer = true;
    const SearchEnd found =
        solve(search, search.scaled_to_fit(from, response), options.max_iterations);
    if (found.cost < best.cost) best = found;
  }
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
    if (!(ratio > kTooSmall)) break;
    widened *= ratio;
    wider.shared *= ratio;
    out = identify_as_stated(out.material, wider, responses, options);
  }
  for (double& error : out.shared_error) error *= widened;
  return out;
}

}  // namespace palpate::fem
