#pragma once

#include <array>
#include <limits>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/fit/rows/rows.hpp"
#include "libfit/runtime/series/quadric_replay.hpp"

namespace palpate::fit {

/// The bases of a family's parts as tables, with the views the engine's templates take.
/// Not copyable: views point into the tables.
struct Bases {
  explicit Bases(const std::vector<CurveBasis>& basis, CurveFamily family = CurveFamily::separable,
                 const Relaxation& relaxation = {});
  Bases(const Bases&) = delete;
  Bases& operator=(const Bases&) = delete;

  CurveFamily family;
  std::vector<SplineTables> tables;
  runtime::CurveViews views;
};

inline Bases::Bases(const std::vector<CurveBasis>& basis, CurveFamily of,
                    const Relaxation& relaxation)
    : family(of) {
  views.family = static_cast<int>(family);
  for (const CurveBasis& b : basis)
    tables.push_back(b.knots_m.empty() ? SplineTables{} : tabulate(b));
  for (std::size_t part = 0; part < tables.size(); ++part)
    if (tables[part].pieces > 0) views.view[part] = view(tables[part]);
  prepare(views);
  views.relaxation = relaxation_view(relaxation);
}

inline Bases bases_of(const CurveSet& curves) {
  return Bases(curves.basis, curves.family, curves.relaxation);
}

/// Number of unknowns of a part that is no curve at a point: vectors and tensors are
/// tangential.
inline int count_unknowns(const runtime::Part& part) {
  if (part.known != runtime::Known::no) return 0;
  return part.count * (part.width == 1 ? 1 : part.width == 3 ? 2 : 3);
}

/// Calls visit(i, part, at) for each part i that is no curve; its unknowns begin at number `at` of
/// those of all such parts.
template <class Visit>
void each_other_part(CurveFamily family, const Visit& visit) {
  const auto parts = parts_of(family);
  int at = 0;
  for (std::size_t i = curves_of(family); i < parts.size(); ++i) {
    visit(i, parts[i], at);
    at += count_unknowns(parts[i]);
  }
}

/// The surface a point's experiments are replayed on; gradient in 1 / the unit of length.
inline runtime::Quadric quadric_of(const Vec3& inward, const Mat3& normal_gradient) {
  runtime::Quadric quadric{{inward.x(), inward.y(), inward.z()}, {}};
  for (int i = 0; i < 9; ++i) quadric.gradient[i] = normal_gradient(i / 3, i % 3);
  return quadric;
}
inline runtime::Quadric quadric_of(const PointData& point) {
  return quadric_of(point.inward, point.normal_gradient);
}

/// The numbers of a part that is no curve from its count_unknowns() unknowns: components of vectors
/// along the point's tangents t, b, of symmetric tensors along tt, bb and tb + bt. quadric: the
/// point's surface, lengths over length_m. sway: compliance there; zero where rows are without it.
template <class T, class C>
std::vector<T> part_controls(const runtime::Part& part, const runtime::Quadric& quadric,
                             const C* unknowns, const Mat3& sway = Mat3::Zero()) {
  const auto [t, b] = tangents_of({quadric.u0.x, quadric.u0.y, quadric.u0.z});
  const int count = count_unknowns(part);
  std::vector<T> control;
  if (part.width == 1)
    for (int j = 0; j < count; ++j) control.push_back(T(unknowns[j]));
  if (part.width == 3)
    for (int j = 0; j + 1 < count; j += 2)
      for (int i = 0; i < 3; ++i) control.push_back(unknowns[j] * t[i] + unknowns[j + 1] * b[i]);
  if (part.known == runtime::Known::tools) control.assign(part.count, T(0.0));
  constexpr int kAt[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
  if (part.known == runtime::Known::curvature) {
    double kappa[6];
    for (int i = 0; i < 6; ++i) kappa[i] = -quadric.gradient[3 * kAt[i][0] + kAt[i][1]];
    runtime::offset_curvature(kappa, -runtime::kCurvatureDepth);  // (M15c)
    for (const double k : kappa) control.push_back(T(k));
  }
  if (part.known == runtime::Known::sway)
    for (const auto& [r, c] : kAt) control.push_back(T(sway(r, c)));
  if (part.width == 6)
    for (int j = 0; j + 2 < count; j += 3)
      for (const auto& [r, c] : kAt)
        control.push_back(unknowns[j] * (t[r] * t[c]) + unknowns[j + 1] * (b[r] * b[c]) +
                          unknowns[j + 2] * (t[r] * b[c] + b[r] * t[c]));
  return control;
}

/// Pointers to the numbers of parts that each have a container of their own.
template <class T, class Values>
runtime::ControlPointers<T> pointers_to(const Values& values) {
  runtime::ControlPointers<T> out{};
  for (std::size_t part = 0; part < values.size(); ++part) out.part[part] = values[part].data();
  return out;
}

/// Pointers to the numbers of a row of a curve set.
inline runtime::ControlPointers<double> controls_at(const CurveSet& curves, Eigen::Index row) {
  runtime::ControlPointers<double> out{};
  for (std::size_t part = 0; part < curves.control.size(); ++part)
    out.part[part] = curves.control[part].row(row).data();
  return out;
}

/// Forces of one experiment, its sensor's reading included (M18); returns how many rows slipped.
template <class T>
int replay(const runtime::CurveViews& views, const runtime::ControlPointers<T>& controls,
           const runtime::Quadric& quadric, const runtime::ReplayedRows& record,
           const std::array<T, kNuisances>& nuisance, bool has_nuisances, runtime::Vec3<T>* force) {
  const int slipped = runtime::replay_drag<T>(views, controls, quadric, record,
                                              has_nuisances ? &nuisance[kContact] : nullptr, force);
  if (!has_nuisances) return slipped;
  const runtime::Vec3<T> inward = runtime::widened<T>(quadric.u0);
  for (int i = 0; i < record.rows; ++i)
    force[i] = force[i] + inward * sensor_reading(nuisance, place_in_recording(i, record.rows));
  return slipped;
}

/// Weighted force differences of one experiment, 3 per row, as a function of the increments of
/// the curves that are fitted (in the order of their kinds) and what is fitted of the family's
/// other parts (part_controls), all in one parameter block; what is unknown of the sensor in a
/// second one. For ceres::DynamicAutoDiffCostFunction. The rest stays at `fixed`.
struct ReplayResidual {
  const Bases* bases;
  runtime::Quadric quadric;
  const PointExperiment* experiment;
  std::array<bool, kCurveKinds> is_fitted;
  std::array<Eigen::VectorXd, kCurveKinds> fixed;  ///< increments
  /// Robust deviation of the rows, from some of which on they count less (loss_factor).
  static constexpr double kNoOutliers = std::numeric_limits<double>::infinity();
  double loss_scale = kNoOutliers;
  const std::vector<double>* weight = nullptr;  ///< of rows; null: the experiment's own

  template <class T>
  bool operator()(const T* const* parameters, T* residual) const {
    const std::size_t curves = curves_of(bases->family);
    std::vector<std::vector<T>> control(curves);
    const T* next = parameters[0];
    for (std::size_t kind = 0; kind < curves; ++kind) {
      const Eigen::Index n = fixed[kind].size();
      control[kind].assign(1, T(0));
      for (Eigen::Index j = 0; j < n; ++j)
        control[kind].push_back(control[kind].back() +
                                (is_fitted[kind] ? next[j] : T(fixed[kind][j])));
      if (is_fitted[kind]) next += n;
    }
    each_other_part(bases->family, [&](std::size_t, const runtime::Part& part, int at) {
      control.push_back(part_controls<T>(part, quadric, next + at));
    });
    std::array<T, kNuisances> nuisance;
    nuisance.fill(T(0));
    int unknown = 0;
    for (int k = 0; k < kNuisances; ++k)
      if (experiment->unknown[k] > 0) nuisance[k] = parameters[1][unknown++];
    const auto rows = static_cast<int>(experiment->row.size());
    std::vector<runtime::Vec3<T>> force(rows);
    replay<T>(bases->views, pointers_to<T>(control), quadric,
              {experiment->deflection.front().data(), rows}, nuisance, unknown > 0, force.data());
    const std::vector<double>& weights = weight != nullptr ? *weight : experiment->weight;
    for (std::size_t i = 0; i < force.size(); ++i) {
      const Vec3& measured = experiment->force[i];
      T* r = residual + 3 * i;
      r[0] = weights[i] * (force[i].x - measured.x());
      r[1] = weights[i] * (force[i].y - measured.y());
      r[2] = weights[i] * (force[i].z - measured.z());
      const T squared = r[0] * r[0] + r[1] * r[1] + r[2] * r[2];
      if (!(squared > 1e-12 * loss_scale * loss_scale)) continue;
      using std::sqrt;
      const T factor = loss_factor(loss_scale, T(sqrt(squared)));
      for (int k = 0; k < 3; ++k) r[k] = r[k] * factor;
    }
    return true;
  }
};

/// Curves on the quadric around a place (docs/method.md, M11), which answer experiments there.
/// Not owned: what it points to must outlive it.
struct LocalCurves {
  const Bases* bases;
  runtime::ControlPointers<double> controls;
  runtime::Quadric quadric;
};
/// A row of `curves`, whose bases these are, at a point of the samples.
LocalCurves curves_at(const Bases& bases, const CurveSet& curves, Eigen::Index row,
                      const Samples& samples, Eigen::Index point);

/// The point of `curves` at a place, within 1e-6 of their extent, if it has curves; else -1.
Eigen::Index point_at(const FittedCurves& curves, const Vec3& place);

/// Answers of curves to the rows of one experiment.
struct LocalAnswer {
  Points force;  ///< ON THE BODY, #rows x 3
  int slipped_rows = 0;
};
/// Forces of a tool that follows `path`, #rows x 3, deflections from the place, in order: the
/// law of section 4 as the fit has it. time_s: of each row since first touch, or null in slow
/// motion. sensor: nuisance values, added to its reading (M18). Units are those of the curves.
LocalAnswer local_answer(const LocalCurves& curves, const Points& path,
                         const double* time_s = nullptr, const NuisanceValues& sensor = {});
/// Answers to rows of samples, in their time where they have one [m, N].
LocalAnswer local_answer(const LocalCurves& curves, const Samples& samples,
                         const std::vector<Eigen::Index>& rows, const NuisanceValues& sensor = {});

}  // namespace palpate::fit
