#include "libfit/fit/solve_point.hpp"

#include <ceres/ceres.h>

#include <cmath>

namespace palpate::fit {
namespace {

constexpr double kExactRows = 1e-5;  // of the force: rows this close to a curve need no smoothing
constexpr int kJetWidth = 8;  // derivatives per replay: a Jet of 8 fits one AVX-512 register

// strength (matrix x - target) on one slice of the parameters, among rows of the given weight.
struct FaintResidual {
  const Faint* faint;
  Eigen::Index offset;
  double weight;

  template <class T>
  bool operator()(const T* const* parameters, T* residual) const {
    const double strength = weight * faint->strength;
    for (Eigen::Index i = 0; i < faint->matrix.rows(); ++i) {
      residual[i] = T(-strength * faint->target[i]);
      for (Eigen::Index j = 0; j < faint->matrix.cols(); ++j)
        if (faint->matrix(i, j) != 0)
          residual[i] += strength * faint->matrix(i, j) * parameters[0][offset + j];
    }
    return true;
  }
};

template <class Functor>
ceres::CostFunction* automatic(Functor* functor, Eigen::Index parameters, Eigen::Index residuals) {
  auto* cost = new ceres::DynamicAutoDiffCostFunction<Functor, kJetWidth>(functor);
  cost->AddParameterBlock(static_cast<int>(parameters));
  cost->SetNumResiduals(static_cast<int>(residuals));
  return cost;
}

constexpr double kWidestLean = 3;  // of the deepest row; what no body does
constexpr double kUsualLean = 0.5;  // of the deepest row: standard deviation assumed beforehand

// Faint knowledge that the lean is not large.
struct FaintLean {
  Eigen::Index offset, size;
  double strength;

  template <class T>
  bool operator()(const T* const* parameters, T* residual) const {
    for (Eigen::Index j = 0; j < size; ++j) residual[j] = strength * parameters[0][offset + j];
    return true;
  }
};

Eigen::VectorXd pack(const PointCurves& curves,
                     const std::array<Eigen::VectorXd, kCurveKinds>& values,
                     const Eigen::VectorXd& lean) {
  Eigen::VectorXd packed(0);
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    if (!curves.is_identified[kind]) continue;
    const Eigen::Index old = packed.size();
    packed.conservativeResize(old + values[kind].size());
    packed.tail(values[kind].size()) = values[kind];
  }
  packed.conservativeResize(packed.size() + lean.size());
  packed.tail(lean.size()) = lean;
  return packed;
}

Eigen::VectorXd pack(const PointCurves& curves) {
  return pack(curves, curves.increments, curves.lean);
}

void unpack(const Eigen::VectorXd& packed, PointCurves& curves) {
  Eigen::Index at = 0;
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    if (!curves.is_identified[kind]) continue;
    const Eigen::Index n = curves.increments[kind].size();
    curves.increments[kind] = packed.segment(at, n);
    at += n;
  }
  curves.lean = packed.tail(curves.lean.size());
}

ReplayResidual residual_of(const PointData& point, const Bases& bases, const Experiment& e,
                           const PointCurves& curves) {
  return {&bases, quadric_of(point.inward, point.normal_gradient), &e, curves.is_identified,
          curves.increments, FitLoss::squared, 1, tangents_of(point.inward)};
}

// Robust deviation of the weighted residuals' sizes at the given parameters.
double residual_scale(const PointData& point, const Bases& bases, const PointCurves& curves,
                      const Eigen::VectorXd& parameters) {
  std::vector<double> sizes, residual;
  const double* block = parameters.data();
  for (const Experiment& e : point.experiments) {
    residual.resize(3 * e.row.size());
    residual_of(point, bases, e, curves)(&block, residual.data());
    for (std::size_t i = 0; i < e.row.size(); ++i)
      if (e.weight[i] > 0)  // rows held out have none
        sizes.push_back(std::hypot(residual[3 * i], residual[3 * i + 1], residual[3 * i + 2]));
  }
  return robust_deviation(std::move(sizes));
}

double root_mean_square_weight(const PointData& point) {
  double sum = 0, rows = 0;
  for (const Experiment& e : point.experiments)
    for (const double w : e.weight) sum += w * w, rows += w > 0;
  return std::sqrt(sum / rows);
}

ceres::Solver::Options solver_options() {
  ceres::Solver::Options options;
  options.num_threads = 1;
  options.linear_solver_type = ceres::DENSE_QR;
  options.dense_linear_algebra_library_type = ceres::EIGEN;  // no BLAS threads, same bits anywhere
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = 60;
  options.function_tolerance = 1e-13;
  options.parameter_tolerance = 1e-11;
  options.gradient_tolerance = 1e-14;
  return options;
}

// One solve from the curves as they are; rows further than the robust `scale` count less.
void refine(const PointData& point, const Bases& bases, FitLoss loss, double scale,
            PointCurves& curves) {
  Eigen::VectorXd parameters = pack(curves);
  const Eigen::VectorXd lower =
      pack(curves, curves.lower, Eigen::VectorXd::Constant(curves.lean.size(), -kWidestLean));
  ceres::Problem problem;
  problem.AddParameterBlock(parameters.data(), static_cast<int>(parameters.size()));
  for (Eigen::Index j = 0; j < lower.size(); ++j)
    problem.SetParameterLowerBound(parameters.data(), static_cast<int>(j), lower[j]);
  for (Eigen::Index j = lower.size() - curves.lean.size(); j < lower.size(); ++j)
    problem.SetParameterUpperBound(parameters.data(), static_cast<int>(j), kWidestLean);
  for (const Experiment& e : point.experiments) {
    auto* residual = new ReplayResidual(residual_of(point, bases, e, curves));
    residual->loss = loss;
    residual->loss_scale = scale;
    problem.AddResidualBlock(automatic(residual, parameters.size(),
                                       static_cast<Eigen::Index>(3 * e.row.size())),
                             nullptr, parameters.data());
  }
  const double weight = root_mean_square_weight(point);
  Eigen::Index offset = 0;
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    if (!curves.is_identified[kind]) continue;
    problem.AddResidualBlock(
        automatic(new FaintResidual{&curves.faint[kind], offset, weight}, parameters.size(),
                  curves.faint[kind].matrix.rows()),
        nullptr, parameters.data());
    offset += curves.increments[kind].size();
  }
  if (curves.lean.size() > 0)
    problem.AddResidualBlock(
        automatic(new FaintLean{offset, curves.lean.size(), weight * curves.lean_strength},
                  parameters.size(), curves.lean.size()),
        nullptr, parameters.data());

  ceres::Solver::Summary summary;
  ceres::Solve(solver_options(), &problem, &summary);
  if (!summary.IsSolutionUsable() || !parameters.allFinite()) return;
  if (!(summary.final_cost <= summary.initial_cost)) return;
  unpack(parameters.cwiseMax(lower), curves);
}

}  // namespace

void solve_point(const PointData& point, const Bases& bases, const FitOptions& options,
                 PointCurves& curves) {
  if (pack(curves).size() == 0) return;
  // Below a thousandth of the weight floor residuals are rounding: no outlier is told from them.
  const auto scale_of = [&](const PointCurves& c) {
    return std::max(residual_scale(point, bases, c, pack(c)), 1e-3);
  };
  const PointCurves start = curves;
  for (Faint& faint : curves.faint) faint.strength = kFaint;
  refine(point, bases, options.loss, scale_of(curves), curves);

  // What the best curves leave unexplained is the rows' scatter, and faint knowledge weighs by it.
  const double scale = scale_of(curves);
  const double noise = scale / std::sqrt(3.0) / root_mean_square_weight(point);
  if (noise < kExactRows) return;
  PointCurves again = start;
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind)
    if (again.is_identified[kind])
      again.faint[kind].strength =
          again.faint[kind].per_noise * noise / start.increments[kind].sum();
  again.lean_strength = noise / kUsualLean;
  refine(point, bases, options.loss, scale, again);
  curves = again;
}

}  // namespace palpate::fit
