#pragma once

#include <array>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/fit/experiments.hpp"
#include "libfit/fit/monotone_least_squares.hpp"
#include "libfit/runtime/quadric.hpp"

namespace palpate::fit {

/// The bases as tables, with the views the engine's templates take. lean: without knots where the
/// body does not lean. Not copyable: views point into the tables.
struct Bases {
  explicit Bases(const std::array<CurveBasis, kCurveKinds>& basis, const CurveBasis& lean = {});
  Bases(const Bases&) = delete;
  Bases& operator=(const Bases&) = delete;

  bool leans() const { return views.lean.pieces > 0; }

  std::array<SplineTables, kCurveKinds> tables;
  SplineTables lean_table;
  runtime::CurveViews views;
};

inline Bases::Bases(const std::array<CurveBasis, kCurveKinds>& basis, const CurveBasis& lean) {
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    tables[kind] = tabulate(basis[kind]);
    views.view[kind] = view(tables[kind]);
  }
  if (lean.knots_m.empty()) return;
  lean_table = tabulate(lean);
  views.lean = view(lean_table);
}

/// Control values of a lean, x, y, z of each in turn, from its components along a point's tangents
/// (two of each control value but the first, which is 0).
template <class T, class C>
std::vector<T> lean_controls(const std::array<Vec3, 2>& tangents, const C* components, int count) {
  std::vector<T> control(3, T(0));
  for (int j = 0; j + 1 < count; j += 2)
    for (int i = 0; i < 3; ++i)
      control.push_back(components[j] * tangents[0][i] + components[j + 1] * tangents[1][i]);
  return control;
}

/// The surface a point's experiments are replayed on; gradient in 1 / the unit of length.
inline runtime::Quadric quadric_of(const Vec3& inward, const Mat3& normal_gradient) {
  runtime::Quadric quadric{{inward.x(), inward.y(), inward.z()}, {}};
  for (int i = 0; i < 9; ++i) quadric.gradient[i] = normal_gradient(i / 3, i % 3);
  return quadric;
}

/// Weighted force differences of one experiment, 3 per row, as a function of the increments of
/// the curves that are fitted (in the order of their kinds) and, in a body that leans, the lean's
/// components along `tangents`, all in one parameter block; for ceres::DynamicAutoDiffCostFunction.
/// The rest stays at `fixed`.
struct ReplayResidual {
  const Bases* bases;
  runtime::Quadric quadric;
  const Experiment* experiment;
  std::array<bool, kCurveKinds> is_fitted;
  std::array<Eigen::VectorXd, kCurveKinds> fixed;  ///< increments
  FitLoss loss = FitLoss::squared;
  double loss_scale = 1;
  std::array<Vec3, 2> tangents{};

  template <class T>
  bool operator()(const T* const* parameters, T* residual) const {
    std::array<std::vector<T>, kCurveKinds> control;
    const T* next = parameters[0];
    for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
      const Eigen::Index n = fixed[kind].size();
      control[kind].assign(1, T(0));
      for (Eigen::Index j = 0; j < n; ++j)
        control[kind].push_back(control[kind].back() +
                                (is_fitted[kind] ? next[j] : T(fixed[kind][j])));
      if (is_fitted[kind]) next += n;
    }
    const int lean_components = bases->leans() ? 2 * (bases->views.lean.size() - 1) : 0;
    const std::vector<T> lean = lean_controls<T>(tangents, next, lean_components);
    const auto rows = static_cast<int>(experiment->row.size());
    std::vector<runtime::Vec3<T>> force(static_cast<std::size_t>(rows));
    runtime::replay_drag<T>(
        bases->views, {{control[0].data(), control[1].data(), control[2].data()}, lean.data()},
        quadric, experiment->deflection.front().data(), rows, force.data());
    for (std::size_t i = 0; i < force.size(); ++i) {
      const Vec3& measured = experiment->force[i];
      const double w = experiment->weight[i];
      T* r = residual + 3 * i;
      r[0] = w * (force[i].x - measured.x());
      r[1] = w * (force[i].y - measured.y());
      r[2] = w * (force[i].z - measured.z());
      if (loss == FitLoss::squared) continue;
      const T squared = r[0] * r[0] + r[1] * r[1] + r[2] * r[2];
      if (!(squared > 1e-12 * loss_scale * loss_scale)) continue;
      using std::sqrt;
      const T factor = loss_factor(loss, loss_scale, T(sqrt(squared)));
      for (int k = 0; k < 3; ++k) r[k] = r[k] * factor;
    }
    return true;
  }
};

}  // namespace palpate::fit
