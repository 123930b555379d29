#include "libfit/fit/point/point.hpp"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>

namespace palpate::fit {
namespace {

// strength (matrix x - target) on one slice of the parameters, among rows of this weight.
struct WeakPriorResidual {
  const WeakPrior* weak_prior;
  Eigen::Index offset;
  double weight;

  template <class T>
  bool operator()(const T* const* parameters, T* residual) const {
    const double strength = weight * weak_prior->strength;
    for (Eigen::Index i = 0; i < weak_prior->matrix.rows(); ++i) {
      residual[i] = T(-strength * weak_prior->target[i]);
      for (Eigen::Index j = 0; j < weak_prior->matrix.cols(); ++j)
        if (weak_prior->matrix(i, j) != 0)
          residual[i] += strength * weak_prior->matrix(i, j) * parameters[0][offset + j];
    }
    return true;
  }
};

// Each parameter of a slice, from what it is likely to be, times its strength.
struct ExpectedValueResidual {
  Eigen::Index offset;
  Eigen::VectorXd strength;
  Eigen::VectorXd expected;

  template <class T>
  bool operator()(const T* const* parameters, T* residual) const {
    for (Eigen::Index j = 0; j < strength.size(); ++j)
      residual[j] = strength[j] * (parameters[0][offset + j] - expected[j]);
    return true;
  }
};

template <class Functor>
ceres::CostFunction* automatic(Functor* functor, int parameters, int residuals, int more = 0) {
  // A Jet of 8 derivatives fits one AVX-512 register.
  auto* cost = new ceres::DynamicAutoDiffCostFunction<Functor, 8>(functor);
  cost->AddParameterBlock(parameters);
  if (more > 0) cost->AddParameterBlock(more);
  cost->SetNumResiduals(residuals);
  return cost;
}

Eigen::VectorXd pack(const PointCurves& curves,
                     const std::array<Eigen::VectorXd, kCurveKinds>& values,
                     const Eigen::VectorXd& free) {
  Eigen::VectorXd packed(0);
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    if (!curves.is_identified[kind]) continue;
    const Eigen::Index old = packed.size();
    packed.conservativeResize(old + values[kind].size());
    packed.tail(values[kind].size()) = values[kind];
  }
  packed.conservativeResize(packed.size() + free.size());
  packed.tail(free.size()) = free;
  return packed;
}

// The values of those that are unknown.
Eigen::VectorXd pack_nuisances(const NuisanceValues& values, const NuisanceValues& unknown) {
  Eigen::VectorXd packed(kNuisances);
  int count = 0;
  for (int k = 0; k < kNuisances; ++k)
    if (unknown[k] > 0) packed[count++] = values[k];
  return packed.head(count);
}

// The parameters that are optimized.
struct Parameters {
  Eigen::VectorXd curves;
  std::vector<Eigen::VectorXd> nuisance;  // of each experiment, empty where all is known
};

Parameters parameters_of(const PointData& point, const PointCurves& curves) {
  Parameters out{pack(curves, curves.increments, curves.constants), {}};
  for (std::size_t e = 0; e < point.experiments.size(); ++e)
    out.nuisance.push_back(pack_nuisances(curves.nuisance[e], point.experiments[e].unknown));
  return out;
}

void store(const Parameters& parameters, const PointData& point, PointCurves& curves) {
  Eigen::Index at = 0;
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    if (!curves.is_identified[kind]) continue;
    const Eigen::Index n = curves.increments[kind].size();
    curves.increments[kind] = parameters.curves.segment(at, n).cwiseMax(curves.lower[kind]);
    at += n;
  }
  curves.constants = parameters.curves.tail(curves.constants.size());
  for (std::size_t e = 0; e < point.experiments.size(); ++e)
    for (int k = 0, at_nuisance = 0; k < kNuisances; ++k)
      curves.nuisance[e][k] =
          point.experiments[e].unknown[k] > 0 ? parameters.nuisance[e][at_nuisance++] : 0;
}

ReplayResidual residual_of(const PointData& point, const Bases& bases, std::size_t experiment,
                           const PointCurves& curves) {
  return {&bases,
          quadric_of(point),
          &point.experiments[experiment],
          curves.is_identified,
          curves.increments,
          ReplayResidual::kNoOutliers,
          &curves.weight[experiment]};
}

void add_experiments(const PointData& point, const Bases& bases, const PointCurves& curves,
                     double scale, Parameters& parameters, ceres::Problem& problem,
                     std::vector<ceres::ResidualBlockId>& blocks) {
  for (std::size_t e = 0; e < point.experiments.size(); ++e) {
    auto* residual = new ReplayResidual(residual_of(point, bases, e, curves));
    residual->loss_scale = scale;
    Eigen::VectorXd& nuisance = parameters.nuisance[e];
    std::vector<double*> used{parameters.curves.data()};
    if (nuisance.size() > 0) used.push_back(nuisance.data());
    const auto rows = point.experiments[e].row.size();
    blocks.push_back(problem.AddResidualBlock(
        automatic(residual, parameters.curves.size(), 3 * rows, nuisance.size()), nullptr, used));
  }
}

// Weak priors. noise: of a weighted residual, to which the sensor's deviations compare.
void add_priors(const PointData& point, const PointCurves& curves, double noise,
                Parameters& parameters, ceres::Problem& problem,
                std::vector<ceres::ResidualBlockId>& blocks) {
  const double weight = root_mean_square_weight(curves);
  const Eigen::Index all = parameters.curves.size();
  double* block = parameters.curves.data();
  Eigen::Index offset = 0;
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    if (!curves.is_identified[kind]) continue;
    const WeakPrior& weak_prior = curves.weak_prior[kind];
    blocks.push_back(
        problem.AddResidualBlock(automatic(new WeakPriorResidual{&weak_prior, offset, weight}, all,
                                           weak_prior.matrix.rows()),
                                 nullptr, block));
    offset += curves.increments[kind].size();
  }
  const auto expect = [&](double* values, const ExpectedValueResidual& expected,
                          Eigen::Index size) {
    blocks.push_back(problem.AddResidualBlock(
        automatic(new ExpectedValueResidual(expected), size, expected.strength.size()), nullptr,
        values));
  };
  if (offset < all) {
    const Eigen::VectorXd strength =
        curves.constants_noise > 0
            ? Eigen::VectorXd(curves.constants_noise / curves.constants_deviation.array())
            : Eigen::VectorXd::Constant(all - offset, kWeakPrior);
    expect(block, {offset, weight * strength, curves.constants_expected}, all);
  }
  for (std::size_t e = 0; e < point.experiments.size(); ++e) {
    const NuisanceValues& unknown = point.experiments[e].unknown;
    const Eigen::VectorXd deviation = pack_nuisances(unknown, unknown);
    const Eigen::Index count = deviation.size();
    if (count > 0)
      expect(parameters.nuisance[e].data(),
             {0, noise / deviation.array(), Eigen::VectorXd::Zero(count)}, count);
  }
}

void add_bounds(const PointData& point, const PointCurves& curves, Parameters& parameters,
                ceres::Problem& problem) {
  const auto bound = [&](Eigen::VectorXd& values, const Eigen::VectorXd& lower,
                         const Eigen::VectorXd& upper) {
    if (values.size() > 0) problem.AddParameterBlock(values.data(), values.size());
    for (int j = 0; j < values.size(); ++j)
      problem.SetParameterLowerBound(values.data(), j, lower[j]);
    for (int j = values.size() - upper.size(), k = 0; j < values.size(); ++j, ++k)
      problem.SetParameterUpperBound(values.data(), j, upper[k]);
  };
  bound(parameters.curves, pack(curves, curves.lower, curves.constants_lower),
        curves.constants_upper);
  for (std::size_t e = 0; e < point.experiments.size(); ++e) {
    const NuisanceValues& unknown = point.experiments[e].unknown;
    const Eigen::VectorXd widest = 4 * pack_nuisances(unknown, unknown);  // deviations
    bound(parameters.nuisance[e], -widest, widest);
  }
}

ceres::Solver::Options solver_options(int max_iterations) {
  ceres::Solver::Options options;
  options.num_threads = 1;
  options.linear_solver_type = ceres::DENSE_QR;
  options.dense_linear_algebra_library_type = ceres::EIGEN;  // no BLAS threads, same bits anywhere
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = max_iterations;
  options.function_tolerance = 1e-13;
  options.parameter_tolerance = 1e-11;
  options.gradient_tolerance = 1e-14;
  return options;
}

// Residuals and Jacobian of some blocks, parameters in the order of `parameters`.
Eigen::MatrixXd evaluate(ceres::Problem& problem, Parameters& parameters,
                         std::vector<ceres::ResidualBlockId> blocks,
                         std::vector<double>* residual) {
  ceres::Problem::EvaluateOptions options;
  options.residual_blocks = std::move(blocks);
  options.parameter_blocks.push_back(parameters.curves.data());
  for (Eigen::VectorXd& nuisance : parameters.nuisance)
    if (nuisance.size() > 0) options.parameter_blocks.push_back(nuisance.data());
  ceres::CRSMatrix sparse;
  problem.Evaluate(options, nullptr, residual, nullptr, &sparse);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(sparse.num_rows, sparse.num_cols);
  for (int i = 0; i < sparse.num_rows; ++i)
    for (int k = sparse.rows[i]; k < sparse.rows[i + 1]; ++k)
      dense(i, sparse.cols[k]) = sparse.values[k];
  return dense;
}

}  // namespace

bool has_unknowns(const PointData& point, const PointCurves& curves) {
  return curves.constants.size() > 0 || std::ranges::count(curves.is_identified, true) > 0 ||
         std::ranges::any_of(point.experiments, is_any, &PointExperiment::unknown);
}

double residual_scale(const PointData& point, const Bases& bases, const PointCurves& curves) {
  const Parameters parameters = parameters_of(point, curves);
  std::vector<double> sizes, residual;
  for (std::size_t e = 0; e < point.experiments.size(); ++e) {
    const double* blocks[] = {parameters.curves.data(), parameters.nuisance[e].data()};
    residual.resize(3 * point.experiments[e].row.size());
    residual_of(point, bases, e, curves)(blocks, residual.data());
    for (std::size_t i = 0; i < point.experiments[e].row.size(); ++i)
      if (curves.weight[e][i] > 0)  // rows held out have none
        sizes.push_back(std::hypot(residual[3 * i], residual[3 * i + 1], residual[3 * i + 2]));
  }
  return robust_deviation(std::move(sizes));
}

double root_mean_square_weight(const PointCurves& curves) {
  double sum = 0, rows = 0;
  for (const auto& weights : curves.weight)
    for (const double w : weights) sum += w * w, rows += w > 0;
  return std::sqrt(sum / rows);
}

void refine(const PointData& point, const Bases& bases, double scale, PointCurves& curves,
            int max_iterations) {
  Parameters parameters = parameters_of(point, curves);
  ceres::Problem problem;
  std::vector<ceres::ResidualBlockId> blocks;
  add_bounds(point, curves, parameters, problem);
  add_experiments(point, bases, curves, scale, parameters, problem, blocks);
  add_priors(point, curves, scale, parameters, problem, blocks);
  ceres::Solver::Summary summary;
  ceres::Solve(solver_options(max_iterations), &problem, &summary);
  if (!summary.IsSolutionUsable() || !parameters.curves.allFinite()) return;
  if (!(summary.final_cost <= summary.initial_cost)) return;
  store(parameters, point, curves);
}

Linearised linearise(const PointData& point, const Bases& bases, const PointCurves& curves) {
  Parameters parameters = parameters_of(point, curves);
  ceres::Problem problem;
  std::vector<ceres::ResidualBlockId> rows, priors;
  add_experiments(point, bases, curves, ReplayResidual::kNoOutliers, parameters, problem, rows);
  add_priors(point, curves, curves.scale, parameters, problem, priors);
  std::vector<double> residual;
  Linearised out;
  out.rows = evaluate(problem, parameters, std::move(rows), &residual);
  out.residual = Eigen::Map<const Eigen::VectorXd>(residual.data(), residual.size());
  out.prior = evaluate(problem, parameters, std::move(priors), nullptr);
  return out;
}

}  // namespace palpate::fit
