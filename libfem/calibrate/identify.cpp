#include "libfem/calibrate/identify.hpp"

#include <ceres/ceres.h>

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <unsupported/Eigen/SpecialFunctions>

namespace palpate::fem {
namespace {

using Eigen::Index, Eigen::MatrixXd, Eigen::VectorXd;

constexpr double kAssumedDeviation = 0.01;  // of the largest value, where no row states one
constexpr double kScatter = 1e-3;           // of the largest value: what a solver leaves
constexpr double kSmallest = 0.01;     // of the sum of moduli: below it a modulus is scaled by that
constexpr double kUndetermined = 0.5;  // relative deviation of what the data do not tell
constexpr double kEnough = 0.005;      // of the cost, in variances
constexpr double kScatterOfStarts = 1.5;
constexpr double kReach = 12;  // how far bounds are looked for, in units of the search

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

// Where the search stands for a parameter: its logarithm (times its sign) or its value over `unit`.
struct Coordinate {
  std::size_t index;
  bool is_log = false;
  double unit = 1;  // with its sign where is_log
  double low = -std::numeric_limits<double>::infinity(),
         high = std::numeric_limits<double>::infinity();

  double to(double value) const { return is_log ? std::log(value / unit) : value / unit; }
  double from(double y) const { return unit * (is_log ? std::exp(y) : y); }
  double slope(double y) const { return is_log ? from(y) : unit; }
};

class MaterialSearch final : public ceres::CostFunction {
 public:
  MaterialSearch(MaterialParameters start, const Observations& observed,
                 const MaterialResponses& responses, const IdentifyOptions& options)
      : law_(find_law(start.law, "law")),
        start_(std::move(start)),
        value_(observed.value),
        responses_(responses),
        options_(options) {
    const double largest = value_.lpNorm<Eigen::Infinity>();
    std::vector<double> stated;
    for (const double s : observed.deviation)
      if (s > 0 && std::isfinite(s)) stated.push_back(s);
    std::nth_element(stated.begin(), stated.begin() + stated.size() / 2, stated.end());
    is_stated = !stated.empty();
    const double usual = is_stated ? stated[stated.size() / 2] : kAssumedDeviation * largest;
    deviation = observed.deviation.unaryExpr([&](double s) {
      return std::hypot(s > 0 && std::isfinite(s) ? s : usual, is_stated ? kScatter * largest : 0);
    });
    find_scaling();
    make_coordinates();
    set_num_residuals(static_cast<int>(value_.size()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(coordinates.size()));
  }

  MaterialParameters at(const double* y) const {
    MaterialParameters material = start_;
    for (std::size_t k = 0; k < coordinates.size(); ++k)
      material.values[coordinates[k].index] = coordinates[k].from(y[k]);
    return material;
  }
  VectorXd place(const MaterialParameters& material) const {
    VectorXd y(static_cast<Index>(coordinates.size()));
    for (std::size_t k = 0; k < coordinates.size(); ++k)
      y[static_cast<Index>(k)] =
          std::clamp(coordinates[k].to(material.values[coordinates[k].index]), coordinates[k].low,
                     coordinates[k].high);
    return y;
  }
  bool is_refused(const MaterialParameters& material) const {
    return law_.refusal(material.values).is_refused();
  }
  // Derivatives of the responses by the coordinates; nothing where a material has no answer.
  std::optional<MatrixXd> sensitivities(const VectorXd& y, const VectorXd& response) const {
    const auto k = static_cast<Index>(coordinates.size());
    const MaterialParameters here = at(y.data());
    const Index by_scaling = scales ? largest_free_modulus(here) : -1;
    std::vector<MaterialParameters> materials;
    std::vector<std::pair<Index, double>> step;
    for (Index j = 0; j < k; ++j) {
      if (j == by_scaling) continue;
      const double size = coordinates[static_cast<std::size_t>(j)].is_log
                              ? options_.difference
                              : options_.difference * std::max(std::abs(y[j]), 0.2);
      for (const double side : {1.0, -1.0}) {
        VectorXd moved = y;
        moved[j] += side * size;
        const MaterialParameters material = at(moved.data());
        if (is_refused(material)) continue;
        materials.push_back(material);
        step.emplace_back(j, side * size);
      }
    }
    const std::vector<VectorXd> moved = responses_(materials);
    MatrixXd J = MatrixXd::Zero(value_.size(), k);
    for (Index j = 0; j < k; ++j) {
      std::vector<std::size_t> sides;
      for (std::size_t i = 0; i < step.size(); ++i)
        if (step[i].first == j && moved[i].size() > 0) sides.push_back(i);
      if (j == by_scaling) continue;
      if (sides.empty()) return std::nullopt;
      if (sides.size() == 2)
        J.col(j) = (moved[sides[0]] - moved[sides[1]]) / (2 * step[sides[0]].second);
      else
        J.col(j) = (moved[sides[0]] - response) / step[sides[0]].second;
    }
    if (by_scaling < 0) return J;
    // (M43a): the sum of modulus times derivative is the response.
    VectorXd rest = response;
    for (Index j = 0; j < k; ++j) {
      const Coordinate& c = coordinates[static_cast<std::size_t>(j)];
      if (j != by_scaling && is_modulus(c.index))
        rest -= J.col(j) * (here.values[c.index] / c.slope(y[j]));
    }
    const Coordinate& c = coordinates[static_cast<std::size_t>(by_scaling)];
    J.col(by_scaling) = rest * (c.slope(y[by_scaling]) / here.values[c.index]);
    return J;
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const auto k = static_cast<Index>(coordinates.size());
    const VectorXd y = Eigen::Map<const VectorXd>(parameters[0], k);
    const MaterialParameters material = at(y.data());
    if (options_.progress.stopped() || is_refused(material)) return false;
    const VectorXd response = responses_({material}).front();
    if (response.size() == 0 || !response.allFinite()) return false;
    Eigen::Map<VectorXd>(residuals, value_.size()) = (response - value_).cwiseQuotient(deviation);
    if (!jacobians || !jacobians[0]) return true;
    const std::optional<MatrixXd> J = sensitivities(y, response);
    if (!J) return false;
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
        jacobians[0], value_.size(), k) = deviation.cwiseInverse().asDiagonal() * *J;
    return true;
  }

  // The factor of all moduli that fits best; the material itself where it may not be scaled.
  MaterialParameters scaled_to_fit(MaterialParameters material, const VectorXd& response) const {
    const VectorXd model = response.cwiseQuotient(deviation);
    const double factor = model.dot(value_.cwiseQuotient(deviation)) / model.squaredNorm();
    if (scales && factor > 0)
      for (const std::size_t m : moduli_) material.values[m] *= factor;
    return material;
  }
  // Moduli of the size at which a parameter counts: its own, or where it is nearly 0 a share of
  // all.
  double size_of(const MaterialParameters& material, std::size_t k) const {
    const std::size_t index = coordinates[k].index;
    return std::max(std::abs(material.values[index]),
                    is_modulus(index) ? kSmallest * sum_of_moduli(material) : 1e-9);
  }
  bool is_modulus(std::size_t index) const {
    return std::find(moduli_.begin(), moduli_.end(), index) != moduli_.end();
  }

  std::vector<Coordinate> coordinates;
  VectorXd deviation;
  bool is_stated = false, scales = false;

 private:
  double sum_of_moduli(const MaterialParameters& material) const {
    double sum = 0;
    for (const std::size_t m : moduli_) sum += std::abs(material.values[m]);
    return sum;
  }
  Index largest_free_modulus(const MaterialParameters& material) const {
    Index best = -1;
    for (std::size_t k = 0; k < coordinates.size(); ++k)
      if (is_modulus(coordinates[k].index) &&
          (best < 0 ||
           std::abs(material.values[coordinates[k].index]) >
               std::abs(material.values[coordinates[static_cast<std::size_t>(best)].index])))
        best = static_cast<Index>(k);
    return best;
  }
  void find_scaling() {
    moduli_ = moduli_of(start_);
    const auto is_free = [&](std::size_t i) {
      return std::find(options_.free.begin(), options_.free.end(), i) != options_.free.end();
    };
    scales = options_.may_scale && !moduli_.empty() &&
             std::all_of(moduli_.begin(), moduli_.end(),
                         [&](std::size_t m) { return is_free(m) || start_.values[m] == 0; });
    unit_sum_ = sum_of_moduli(start_);
  }
  void make_coordinates() {
    for (const std::size_t index : options_.free)  // off the border, where there is one side alone
      if (start_.values[index] == 0)
        start_.values[index] = is_modulus(index) ? 0.1 * unit_sum_ : 0.1;
    for (const std::size_t index : options_.free) {
      const double value = start_.values[index];
      const auto refuses = [&](double other, double scale) {
        MaterialParameters material = start_;
        for (const std::size_t i : options_.free)
          if (i != index && is_modulus(i)) material.values[i] *= scale;
        material.values[index] = other;
        return is_refused(material);
      };
      Coordinate c{.index = index};
      c.is_log = refuses(0, 1) && refuses(-value, 1);
      c.unit = c.is_log ? std::copysign(1, value) : is_modulus(index) ? unit_sum_ : 1;
      // A bound that moves with the other parameters is none of this one's.
      const auto bound = [&](double side, double scale) {
        double inside = c.to(value), outside = inside + side * kReach;
        if (!refuses(c.from(outside), scale)) return outside;
        for (int i = 0; i < 100; ++i) {
          const double middle = (inside + outside) / 2;
          (refuses(c.from(middle), scale) ? outside : inside) = middle;
        }
        return std::abs(inside) < 1e-12 && !refuses(0, scale) ? 0 : inside;
      };
      for (const double side : {-1.0, 1.0}) {
        const double found = bound(side, 1);
        if (std::abs(found - c.to(value)) > kReach * 0.999 || refuses(value, 100) ||
            std::abs(bound(side, 100) - found) > 1e-9)
          continue;
        (side < 0 ? c.low : c.high) = found;
      }
      coordinates.push_back(c);
    }
  }

  const LawRow& law_;
  MaterialParameters start_;
  VectorXd value_;
  const MaterialResponses& responses_;
  const IdentifyOptions& options_;
  std::vector<std::size_t> moduli_;
  double unit_sum_ = 1;
};

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
  for (std::size_t k = 0; k < search.coordinates.size(); ++k) {
    const Coordinate& c = search.coordinates[k];
    if (std::isfinite(c.low))
      problem.SetParameterLowerBound(found.y.data(), static_cast<int>(k), c.low);
    if (std::isfinite(c.high))
      problem.SetParameterUpperBound(found.y.data(), static_cast<int>(k), c.high);
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

// How many residuals one independent residual stands for: 1 + 2 sum of their correlations over lags
// within experiments, up to the first that is within two of its own errors (M44).
double rows_each(const VectorXd& r, const std::vector<int>& group) {
  const double variance = r.squaredNorm() / static_cast<double>(r.size());
  double sum = 1;
  for (Index lag = 1; lag < r.size(); ++lag) {
    double products = 0, pairs = 0;
    for (Index i = lag; i < r.size(); ++i)
      if (group[static_cast<std::size_t>(i)] == group[static_cast<std::size_t>(i - lag)]) {
        products += r[i] * r[i - lag];
        ++pairs;
      }
    const double rho = pairs > 0 && variance > 0 ? products / (pairs * variance) : 0;
    if (!(rho * std::sqrt(pairs) > 2)) break;
    sum += 2 * rho;
  }
  return sum;
}

// (M44), and what the observations do not tell.
void state_errors(const MaterialSearch& search, const Observations& observed, const VectorXd& y,
                  double common_error, Identification& out) {
  const auto k = static_cast<Index>(search.coordinates.size());
  const std::optional<MatrixXd> J = search.sensitivities(y, out.response);
  if (!J) {
    out.is_converged = false;
    return;
  }
  VectorXd size(k);
  MatrixXd weighted = search.deviation.cwiseInverse().asDiagonal() * *J;
  for (Index j = 0; j < k; ++j) {
    const auto at = static_cast<std::size_t>(j);
    size[j] = search.size_of(out.material, at);
    weighted.col(j) *= size[j] / search.coordinates[at].slope(y[j]);
  }
  const VectorXd r = (out.response - observed.value).cwiseQuotient(search.deviation);
  const auto n = static_cast<double>(r.size());
  const double per_freedom = r.squaredNorm() / std::max(1.0, n - static_cast<double>(k));
  out.misfit = std::sqrt(per_freedom);
  out.sum_of_squares = (out.response - observed.value).squaredNorm();
  double inflation = 1, rows = n;
  if (!search.is_stated || per_freedom > 1) {
    out.rows_each = rows_each(r, observed.group);
    inflation = per_freedom * out.rows_each;
    rows = n / out.rows_each;
  }
  const double freedom = std::max(1.0, rows - static_cast<double>(k));
  out.region = static_cast<double>(k) * f_quantile(static_cast<double>(k), freedom);
  out.half_width = std::sqrt(f_quantile(1, freedom));

  const Eigen::JacobiSVD<MatrixXd> svd(weighted, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const VectorXd singular =
      svd.singularValues().cwiseMax(1e-9 * svd.singularValues()[0]).cwiseMax(1e-300);
  const MatrixXd V = svd.matrixV();
  const MatrixXd inverse =
      inflation * V * singular.cwiseAbs2().cwiseInverse().asDiagonal() * V.transpose();
  const VectorXd weighted_response = out.response.cwiseQuotient(search.deviation);
  const VectorXd shared =
      common_error / inflation * inverse * (weighted.transpose() * weighted_response);
  const MatrixXd relative = inverse + shared * shared.transpose();
  out.covariance = size.asDiagonal() * relative * size.asDiagonal();
  const VectorXd deviation = out.covariance.diagonal().cwiseSqrt();
  out.correlation = deviation.cwiseInverse().asDiagonal() * out.covariance *
                    deviation.cwiseInverse().asDiagonal();

  for (Index i = 0; i < k; ++i)
    if (std::sqrt(V.col(i).dot(relative * V.col(i))) > kUndetermined) out.are_told_apart = false;
  if (out.are_told_apart) return;
  const bool is_product =
      !std::all_of(out.free.begin(), out.free.end(), [&](auto i) { return search.is_modulus(i); });
  for (Index i = 0; i < k; ++i) {
    const double spread = std::sqrt(V.col(i).dot(relative * V.col(i)));
    if (spread > kUndetermined) continue;
    DeterminedCombination one{.weight = V.col(i), .is_product = is_product};
    if (!is_product) one.weight = one.weight.cwiseQuotient(size).eval();
    Index main = 0;
    one.weight.cwiseProduct(is_product ? VectorXd::Ones(k) : size).cwiseAbs().maxCoeff(&main);
    one.weight /= one.weight[main];
    one.value = is_product ? 1 : 0;
    for (Index j = 0; j < k; ++j) {
      const double value = out.material.values[out.free[static_cast<std::size_t>(j)]];
      if (is_product)
        one.value *= std::pow(std::abs(value), one.weight[j]);
      else
        one.value += one.weight[j] * value;
    }
    const VectorXd scaled =
        is_product ? VectorXd(one.value * one.weight.cwiseQuotient(size)) : one.weight;
    one.deviation = std::sqrt(scaled.dot(out.covariance * scaled));
    out.determined.push_back(one);
  }
}

// Other moduli and exponents than those of the start, about it.
MaterialParameters scattered(const MaterialSearch& search, MaterialParameters material,
                             unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-kScatterOfStarts, kScatterOfStarts);
  for (int attempt = 0; attempt < 50; ++attempt) {
    MaterialParameters other = material;
    for (const Coordinate& c : search.coordinates)
      other.values[c.index] *= std::exp(uniform(random));
    if (!search.is_refused(other)) return other;
  }
  return material;
}

}  // namespace

bool Identification::region_holds(const VectorXd& values) const {
  VectorXd off(values.size());
  for (Index j = 0; j < off.size(); ++j)
    off[j] = (values[j] - material.values[free[static_cast<std::size_t>(j)]]) /
             std::sqrt(covariance(j, j));
  return off.dot(correlation.completeOrthogonalDecomposition().solve(off)) <= region;
}

std::vector<std::size_t> identifiable(const MaterialParameters& material) {
  std::vector<std::size_t> out;
  std::size_t at = 0;
  for (const ParameterRow& row : find_law(material.law, "law").parameters) {
    if (row.count == 1 && row.name != kPoissonRow.name && row.name != kBulkRow.name &&
        at < material.values.size() && std::isfinite(material.values[at]))
      out.push_back(at);
    at += static_cast<std::size_t>(row.count);
  }
  return out;
}

Identification identify(const MaterialParameters& start, const Observations& observed,
                        const MaterialResponses& responses, const IdentifyOptions& options) {
  MaterialSearch search(start, observed, responses, options);
  Identification out;
  out.material = start;
  out.free = options.free;
  const MaterialParameters middle = search.at(search.place(start).data());
  SearchEnd best;
  for (int i = 0; i < std::max(1, options.starts) && !options.progress.stopped(); ++i) {
    MaterialParameters from = i == 0 ? middle : scattered(search, middle, static_cast<unsigned>(i));
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

}  // namespace palpate::fem
