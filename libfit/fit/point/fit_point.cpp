#include "libfit/fit/point/point.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "libfit/core/geometry.hpp"
#include "libfit/core/perception.hpp"
#include "libfit/core/text.hpp"
#include "libfit/fit/point/replay.hpp"
#include "libfit/fit/spline/monotone_least_squares.hpp"

namespace palpate::fit {
namespace {

NuisanceValues in_si(const NuisanceValues& s, double length_m, double force_N) {
  return {s[kContact] * length_m, s[kBias] * force_N, s[kDrift] * force_N};
}

double unit_of(const runtime::Part& part, const PointData& point, double length_m) {
  return std::pow(length_m, part.length) * std::pow(point.force_N, part.force);
}

// Standard errors of the numbers of a part that is no curve, which are linear in its unknowns.
// covariance: of these.
Eigen::VectorXd part_deviation(const runtime::Part& part, const PointData& point, double length_m,
                               const Eigen::MatrixXd& covariance) {
  const Eigen::Index count = covariance.rows();
  Eigen::MatrixXd numbers(part.width * part.count, count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::VectorXd unit = Eigen::VectorXd::Unit(count, k);
    const std::vector<double> column = part_controls<double>(part, quadric_of(point), unit.data());
    numbers.col(k) = Eigen::Map<const Eigen::VectorXd>(column.data(), numbers.rows());
  }
  return unit_of(part, point, length_m) *
         (numbers * covariance * numbers.transpose()).diagonal().cwiseMax(0).cwiseSqrt();
}

// Control values as an asset stores them: representable in float32, b_0 = 0, never falling, and
// strictly rising when asked. increments: times force_N [N].
Eigen::VectorXd stored_controls(const Eigen::VectorXd& increments, double force_N,
                                bool is_strictly_rising) {
  Eigen::VectorXd control = controls_of(increments) * force_N;
  float last = 0;
  for (Eigen::Index j = 1; j < control.size(); ++j) {
    auto rounded = static_cast<float>(control[j]);  // to nearest keeps order, but may be equal
    if (!(rounded >= last)) rounded = last;
    if (is_strictly_rising && !(rounded > last))
      rounded = std::nextafter(last, std::numeric_limits<float>::infinity());
    control[j] = last = rounded;
  }
  return control;
}

// Numbers of a part as an asset stores them: exact in float32, within the part's bounds. unknowns:
// in units of length_m and the point's force.
Eigen::VectorXd stored_part(const runtime::Part& part, const PointData& point,
                            const double* unknowns, double length_m) {
  const std::vector<double> control =
      part_controls<double>(part, quadric_of(point), unknowns, point.sway);
  const double unit = unit_of(part, point, length_m);
  Eigen::VectorXd stored(control.size());
  for (Eigen::Index j = 0; j < stored.size(); ++j)
    stored[j] = rounded_to_float(std::clamp(unit * control[j], part.min, part.max));
  return stored;
}

// Bands and nuisance values of a point in SI.
void add_uncertainty(const PointData& point, const CurveRows& rows, const BodyBases& bases,
                     const Bases& plain, const PointCurves& curves, double length_m, Eigen::Index p,
                     FittedCurves& fitted, PointResult& result) {
  const PointCovariance found = covariance(point, plain, curves);
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    if (found.increments[kind].size() == 0) continue;
    const double bias =
        basis_inflation(bases.plain[kind], unit_weights(rows.curve[kind]), found.increments[kind]);
    fitted.covariance[kind].row(p) =
        pack_symmetric(found.increments[kind]) * (bias * point.force_N * point.force_N);
  }
  each_other_part(bases.family, [&](std::size_t i, const runtime::Part& part, int at) {
    const int count = count_unknowns(part);
    if (has_deviation(part) && found.constants.size() > 0)
      fitted.deviation[i].row(p) =
          part_deviation(part, point, length_m, found.constants.block(at, at, count, count));
  });
  for (std::size_t e = 0; e < point.experiments.size(); ++e) {
    result.nuisance.push_back(in_si(curves.nuisance[e], length_m, point.force_N));
    result.nuisance_deviation.push_back(in_si(found.nuisance[e], length_m, point.force_N));
  }
}

// Depth of the first row of a press [m], median over the points.
double first_row_m(const BodyData& body) {
  std::vector<double> first;
  for (const PointData& point : body.points) {
    double least = 0;
    for (const PointExperiment& e : point.experiments) {
      if (e.kind != ExperimentKind::press) continue;
      for (const Vec3& deflection : e.deflection)
        if (const double d = depth_of(point, deflection); d > 0 && (least == 0 || d < least))
          least = d;
    }
    if (least > 0) first.push_back(least * body.length_m);
  }
  return median(first);
}

}  // namespace

PointScore score_point(const Samples& samples, const PointData& point, double length_m,
                       const Bases& bases_m, const FittedCurves& fitted, Eigen::Index p,
                       const std::vector<NuisanceValues>& nuisance) {
  const LocalCurves curves{&bases_m, controls_at(fitted.curves, p),
                           quadric_of(point.inward, point.normal_gradient / length_m)};
  PointScore score;
  double square = 0, force_square = 0, rows = 0;
  for (std::size_t at = 0; at < point.experiments.size(); ++at) {
    const PointExperiment& e = point.experiments[at];
    const LocalAnswer answer =
        local_answer(curves, samples, e.row, nuisance.empty() ? NuisanceValues{} : nuisance[at]);
    score.slipped_rows += answer.slipped_rows;
    for (std::size_t i = 0; i < e.row.size(); ++i) {
      const Vec3 measured = samples.force.row(e.row[i]);
      const double size = (Vec3(answer.force.row(i)) - measured).norm();
      square += size * size, force_square += measured.squaredNorm(), ++rows;
      score.rows.push_back({size, measured.norm()});
      if (size > score.max_N || rows == 1) {
        score.max_N = size;
        score.worst_experiment = e.id;
        score.worst_row = i;
      }
    }
  }
  score.rms_N = std::sqrt(square / rows);
  score.relative = std::sqrt(square / force_square);
  return score;
}

FittedCurves no_curves(const Samples& samples, const BodyData& body, const BodyBases& bases) {
  const Eigen::Index points = samples.points();
  FittedCurves out;
  out.position = samples.point_position;
  out.normal = samples.point_normal;
  out.name = samples.point_name;
  out.curves = CurveSet(bases.family);
  out.curves.basis = bases.si;
  if (bases.family == CurveFamily::rings) {
    out.curves.relaxation = samples.relaxation;
    out.curves.relaxation.radius_m = ball_radius_m(samples.probe);
  }
  out.curves.first_row_m = first_row_m(body);
  const auto parts = parts_of(bases.family);
  out.deviation.resize(parts.size());
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const int numbers = parts[i].width * size_of(parts[i], bases.si[i]);
    out.curves.control[i].setZero(points, numbers);
    if (has_deviation(parts[i])) out.deviation[i].setConstant(points, numbers, kNan);
  }
  for (std::size_t kind = 0; kind < curves_of(bases.family); ++kind)
    out.covariance[kind].setConstant(points, packed_size(bases.si[kind].size() - 1), kNan);
  out.status.assign(points, FitStatus::failed);
  out.rms_residual_N = out.max_residual_N = Eigen::VectorXd::Constant(points, kNan);
  out.depth_range_m.resize(points);
  for (Eigen::Index p = 0; p < points; ++p) {
    out.message.push_back(body.points[p].problem);
    out.depth_range_m[p] = body.points[p].depth_m;
  }
  return out;
}

PointCurves identify(const PointData& point, const CurveRows& rows, const BodyBases& bases,
                     const Bases& plain, const FitOptions& options) {
  PointCurves curves = start_values(point, rows, bases, options);
  if (!curves.problem.empty()) return curves;
  solve_point(point, plain, curves);
  if (curves_of(bases.family) == kCurveKinds &&
      !curves.is_identified[2])  // made up from f^z, which may have moved
    curves.increments[2] =
        transfer(bases.plain[0], curves.increments[0], bases.plain[2], curves.friction);
  return curves;
}

PointResult fit_point(const Samples& samples, const BodyData& body, Eigen::Index p,
                      const CurveRows& rows, const BodyBases& bases, const Bases& plain,
                      const Bases& si, const FitOptions& options, FittedCurves& fitted) {
  PointResult result;
  const PointData& point = body.points[p];
  if (!point.problem.empty()) return result;
  PointCurves curves = identify(point, rows, bases, plain, options);
  std::string& message = fitted.message[p];
  message = curves.problem;
  if (!curves.problem.empty()) return result;
  const std::size_t kinds = curves_of(bases.family);
  for (std::size_t kind = 0; kind < kinds; ++kind)
    fitted.curves.control[kind].row(p) =
        stored_controls(curves.increments[kind], point.force_N, kind == 1);
  each_other_part(bases.family, [&](std::size_t i, const runtime::Part& part, int at) {
    fitted.curves.control[i].row(p) =
        stored_part(part, point, curves.constants.data() + at, body.length_m);
  });

  add_uncertainty(point, rows, bases, plain, curves, body.length_m, p, fitted, result);
  result.score = score_point(samples, point, body.length_m, si, fitted, p, result.nuisance);
  result.is_scored = true;
  if (result.score.slipped_rows == 0 &&
      (kinds < kCurveKinds ? rows.drags > 0 : curves.is_identified[2]))
    add_sentence(curves.message, "no row slips in the fitted model: the limit curve is a guess");
  message = curves.message;
  FitStatus& status = fitted.status[p];
  status = message.empty() ? FitStatus::good : FitStatus::underdetermined;
  if (result.score.relative > perception().force_at_rest) {  // docs/method.md, 8
    if (status == FitStatus::good) status = FitStatus::poor;
    add_sentence(message, "residual is " + percent(result.score.relative) +
                              " of the force, worst in experiment " +
                              std::to_string(result.score.worst_experiment));
  }
  return result;
}

LocalCurves curves_at(const Bases& bases, const CurveSet& curves, Eigen::Index row,
                      const Samples& samples, Eigen::Index point) {
  return {&bases, controls_at(curves, row),
          quadric_of(samples.point_normal.row(point), offset_gradient(samples, point))};
}

Eigen::Index point_at(const FittedCurves& curves, const Vec3& place) {
  Eigen::Index nearest = 0;
  const double distance_m =
      (curves.position.rowwise() - place.transpose()).rowwise().norm().minCoeff(&nearest);
  const bool is_there = distance_m <= 1e-6 * extent_m(curves.position).norm() &&
                        curves.status[nearest] != FitStatus::failed;
  return is_there ? nearest : -1;
}

LocalAnswer local_answer(const LocalCurves& curves, const Points& path, const double* time_s,
                         const NuisanceValues& sensor) {
  std::vector<runtime::Vec3d> force(path.rows());
  LocalAnswer out{Points(path.rows(), 3)};
  out.slipped_rows = replay<double>(curves.bases->views, curves.controls, curves.quadric,
                                    {path.data(), static_cast<int>(path.rows()), time_s}, sensor,
                                    is_any(sensor), force.data());
  for (Eigen::Index i = 0; i < path.rows(); ++i)
    out.force.row(i) << force[i].x, force[i].y, force[i].z;
  return out;
}

LocalAnswer local_answer(const LocalCurves& curves, const Samples& samples,
                         const std::vector<Eigen::Index>& rows, const NuisanceValues& sensor) {
  const Points path = samples.deflection(rows, Eigen::all);
  if (samples.time_s.size() == 0) return local_answer(curves, path, nullptr, sensor);
  const Eigen::VectorXd time_s = samples.time_s(rows);
  return local_answer(curves, path, time_s.data(), sensor);
}

}  // namespace palpate::fit
