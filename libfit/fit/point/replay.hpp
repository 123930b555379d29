#pragma once

#include <array>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/fit/rows/experiments.hpp"
#include "libfit/fit/spline/monotone_least_squares.hpp"
#include "libfit/runtime/quadric.hpp"

namespace palpate::fit {

/// The bases as tables, with the views the engine's templates take. lean: without knots where the
/// body does not lean. A coupled body's gain is 1 at the last knot of the normal basis.
/// Not copyable: views point into the tables.
struct Bases {
  explicit Bases(const std::array<CurveBasis, kCurveKinds>& basis, const CurveBasis& lean = {},
                 bool is_coupled = false, bool is_anisotropic = false);
  Bases(const Bases&) = delete;
  Bases& operator=(const Bases&) = delete;

  bool leans() const { return views.lean.pieces > 0; }

  std::array<SplineTables, kCurveKinds> tables;
  SplineTables lean_table;
  runtime::CurveViews views;
};

inline Bases::Bases(const std::array<CurveBasis, kCurveKinds>& basis, const CurveBasis& lean,
                    bool is_coupled, bool is_anisotropic) {
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    tables[kind] = tabulate(basis[kind]);
    views.view[kind] = view(tables[kind]);
  }
  if (is_coupled) views.coupling_depth_m = basis[0].knots_m.back();
  views.is_anisotropic = is_anisotropic;
  if (lean.knots_m.empty()) return;
  lean_table = tabulate(lean);
  views.lean = view(lean_table);
}

inline Bases bases_of(const CurveSet& curves) {
  return Bases(curves.basis, curves.lean_basis, curves.is_coupled, is_anisotropic(curves.family()));
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

/// The anisotropy S of two unbounded numbers v: s (a (t t' - b b') + b (t b' + b t')) over a
/// point's tangents t, b with (a, b) = 0.63 v / sqrt(1 + v.v); no trace, norm below 0.9.
template <class T, class C>
std::array<T, runtime::kTensorSize> anisotropy_of(const std::array<Vec3, 2>& tangents, const C* v) {
  using std::sqrt;
  constexpr double kMax = 0.63;  // times sqrt(2), the norm, just below runtime::kMaxAnisotropy
  const T scale = T(kMax) / sqrt(T(1) + v[0] * v[0] + v[1] * v[1]);
  const Mat3 along = tangents[0] * tangents[0].transpose() - tangents[1] * tangents[1].transpose();
  const Mat3 across = tangents[0] * tangents[1].transpose() + tangents[1] * tangents[0].transpose();
  constexpr int kAt[runtime::kTensorSize][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
  std::array<T, runtime::kTensorSize> out;
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = scale * (v[0] * along(kAt[i][0], kAt[i][1]) + v[1] * across(kAt[i][0], kAt[i][1]));
  return out;
}

/// Where the numbers of a row of a curve set are.
inline runtime::ControlPointers<double> controls_at(const CurveSet& curves, Eigen::Index row) {
  runtime::ControlPointers<double> out{};
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind)
    out.curve[kind] = curves.control[kind].row(row).data();
  if (curves.lean.cols() > 0) out.lean = curves.lean.row(row).data();
  if (curves.anisotropy.cols() > 0) out.anisotropy = curves.anisotropy.row(row).data();
  return out;
}

/// The surface a point's experiments are replayed on; gradient in 1 / the unit of length.
inline runtime::Quadric quadric_of(const Vec3& inward, const Mat3& normal_gradient) {
  runtime::Quadric quadric{{inward.x(), inward.y(), inward.z()}, {}};
  for (int i = 0; i < 9; ++i) quadric.gradient[i] = normal_gradient(i / 3, i % 3);
  return quadric;
}

/// runtime::replay_drag of a tip that is `contact` deeper along the inward normal than recorded;
/// with derivatives by it. Same law, same order of operations.
template <class T>
int replay_shifted(const runtime::CurveViews& views, const runtime::ControlPointers<T>& controls,
                   const runtime::Quadric& quadric, const double* deflection, int rows,
                   const T& contact, runtime::Vec3<T>* force) {
  const runtime::Vec3<T> nothing{T(0), T(0), T(0)}, inward = runtime::widened<T>(quadric.u0);
  runtime::QuadricSurface<T> surface{&quadric, controls, nothing};
  bool in_contact = true;
  int slipped = 0;
  runtime::Vec3d before{0, 0, 0};
  for (int row = 0; row < rows; ++row) {
    const runtime::Vec3<T> x =
        runtime::widened<T>(runtime::make_vec3<double>(deflection + 3 * row)) + inward * contact;
    const runtime::Vec3d tip = runtime::values_of(x);
    force[row] = nothing;
    if (!in_contact && depth_below(quadric, before) <= 0 && depth_below(quadric, tip) > 0) {
      surface.p = runtime::widened<T>(runtime::entry_shadow(quadric, before, tip));
      in_contact = true;
    }
    before = tip;
    if (!in_contact) continue;
    auto foot = runtime::footing(views, surface.standing(), x);
    slipped += runtime::slide(views, x, surface, foot) != runtime::SlideEnd::stick;
    force[row] = runtime::response(views, foot.spot, foot.d, foot.lateral_N);
    in_contact = runtime::value_of(foot.d.normal_m) > 0 || row == 0;
  }
  return slipped;
}

/// Forces of one experiment, its sensor's reading included; returns how many rows slipped.
template <class T>
int replay(const runtime::CurveViews& views, const runtime::ControlPointers<T>& controls,
           const runtime::Quadric& quadric, const double* deflection, int rows,
           const std::array<T, 3>& sensor, bool has_sensor, runtime::Vec3<T>* force) {
  if (!has_sensor)
    return runtime::replay_drag<T>(views, controls, quadric, deflection, rows, force);
  const int slipped =
      replay_shifted<T>(views, controls, quadric, deflection, rows, sensor[0], force);
  const runtime::Vec3<T> inward = runtime::widened<T>(quadric.u0);
  for (int i = 0; i < rows; ++i) {
    const double t = part_of_way(static_cast<std::size_t>(i), static_cast<std::size_t>(rows));
    force[i] = force[i] + inward * (sensor[1] + sensor[2] * t);
  }
  return slipped;
}
inline std::array<double, 3> as_array(const Sensor& s) { return {s.contact, s.bias, s.drift}; }
inline bool is_any(const Sensor& s) { return s.contact != 0 || s.bias != 0 || s.drift != 0; }

/// Weighted force differences of one experiment, 3 per row, as a function of the increments of
/// the curves that are fitted (in the order of their kinds) and, in a body that leans, the lean's
/// components along `tangents` and, in an anisotropic one, the two numbers of anisotropy_of, all in
/// one parameter block; what is unknown of the sensor in a second one. For
/// ceres::DynamicAutoDiffCostFunction. The rest stays at `fixed`.
struct ReplayResidual {
  const Bases* bases;
  runtime::Quadric quadric;
  const Experiment* experiment;
  std::array<bool, kCurveKinds> is_fitted;
  std::array<Eigen::VectorXd, kCurveKinds> fixed;  ///< increments
  FitLoss loss = FitLoss::squared;
  double loss_scale = 1;
  std::array<Vec3, 2> tangents{};
  const std::vector<double>* weight = nullptr;  ///< of rows; null: the experiment's own

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
    next += lean_components;
    std::array<T, runtime::kTensorSize> anisotropy{};
    if (bases->views.is_anisotropic) anisotropy = anisotropy_of<T>(tangents, next);
    std::array<T, 3> sensor{T(0), T(0), T(0)};
    const auto unknown = as_array(experiment->unknown);
    int at = 0;
    for (std::size_t k = 0; k < 3; ++k)
      if (unknown[k] > 0) sensor[k] = parameters[1][at++];
    const auto rows = static_cast<int>(experiment->row.size());
    std::vector<runtime::Vec3<T>> force(static_cast<std::size_t>(rows));
    replay<T>(
        bases->views,
        {{control[0].data(), control[1].data(), control[2].data()}, lean.data(), anisotropy.data()},
        quadric, experiment->deflection.front().data(), rows, sensor, at > 0, force.data());
    const std::vector<double>& weights = weight != nullptr ? *weight : experiment->weight;
    for (std::size_t i = 0; i < force.size(); ++i) {
      const Vec3& measured = experiment->force[i];
      const double w = weights[i];
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
