#include "libfit/fit/point/fit_point.hpp"

#include <limits>

#include "libfit/core/text.hpp"
#include "libfit/fit/point/covariance.hpp"
#include "libfit/fit/point/nuisance.hpp"
#include "libfit/fit/spline/curve_band.hpp"

namespace palpate::fit {
namespace {

/// A point whose relative residual is above this is `poor`: the force JND (docs/method.md, 8).
constexpr double kPoorAbove = kForceJnd;

NuisanceValues in_si(const NuisanceValues& s, double length_m, double force_N) {
  return {s.contact * length_m, s.bias * force_N, s.drift * force_N};
}

// Standard errors of the numbers of the parts that are no curves, which are linear in what is
// fitted.
void add_deviations(const PointData& point, const BodyBases& bases, const Eigen::MatrixXd& more,
                    double length_m, PointResult& result) {
  const auto parts = parts_of(bases.family);
  Eigen::Index at = 0;
  for (std::size_t i = curves_of(bases.family); i < parts.size(); ++i) {
    const int count = count_unknowns(parts[i]);
    if (has_deviation(parts[i]) && more.size() > 0) {
      Eigen::MatrixXd numbers(parts[i].width * parts[i].count, count);
      for (int k = 0; k < count; ++k) {
        const Eigen::VectorXd unit = Eigen::VectorXd::Unit(count, k);
        const std::vector<double> column = part_controls<double>(
            parts[i], tangents_of(point.inward), runtime::Quadric{}, unit.data(), count);
        numbers.col(k) = Eigen::Map<const Eigen::VectorXd>(column.data(), numbers.rows());
      }
      const double unit =
          std::pow(length_m, parts[i].length) * std::pow(point.force_N, parts[i].force);
      result.deviation[i] =
          unit * (numbers * more.block(at, at, count, count) * numbers.transpose())
                     .diagonal()
                     .cwiseMax(0)
                     .cwiseSqrt();
    }
    at += count;
  }
}

// Bands and nuisance values of a point in SI.
void add_uncertainty(const PointData& point, const CurveRows& rows, const BodyBases& bases,
                     const Bases& plain, const PointCurves& curves, double length_m,
                     PointResult& result) {
  const PointCovariance found = covariance(point, plain, curves);
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    if (found.increments[kind].size() == 0) continue;
    const double bias =
        basis_inflation(bases.plain[kind], unit_weights(rows.curve[kind]), found.increments[kind]);
    result.covariance[kind] =
        pack_symmetric(found.increments[kind]) * (bias * point.force_N * point.force_N);
  }
  add_deviations(point, bases, found.more, length_m, result);
  for (std::size_t e = 0; e < point.experiments.size(); ++e) {
    result.nuisance.push_back(in_si(curves.nuisance[e], length_m, point.force_N));
    result.nuisance_deviation.push_back(in_si(found.nuisance[e], length_m, point.force_N));
  }
}

}  // namespace

PointResult no_curves(const BodyBases& bases, const std::string& why) {
  PointResult result;
  const auto parts = parts_of(bases.family);
  for (std::size_t i = 0; i < parts.size(); ++i)
    result.control.push_back(
        Eigen::VectorXd::Zero(parts[i].width * size_of(parts[i], bases.si[i])));
  for (std::size_t kind = 0; kind < curves_of(bases.family); ++kind)
    result.covariance[kind] = Eigen::VectorXd::Constant(packed_size(bases.si[kind].size() - 1),
                                                        std::numeric_limits<double>::quiet_NaN());
  result.deviation.resize(parts.size());
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (has_deviation(parts[i]))
      result.deviation[i] = Eigen::VectorXd::Constant(result.control[i].size(),
                                                      std::numeric_limits<double>::quiet_NaN());
  result.message = why;
  return result;
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

PointResult fit_point(const Samples& samples, const PointData& point, const CurveRows& rows,
                      double length_m, const BodyBases& bases, const Bases& plain, const Bases& si,
                      const FitOptions& options) {
  PointResult result = no_curves(bases, point.problem);
  if (!point.problem.empty()) return result;
  PointCurves curves = identify(point, rows, bases, plain, options);
  result.message = curves.problem;
  if (!curves.problem.empty()) return result;
  const std::size_t kinds = curves_of(bases.family);
  for (std::size_t kind = 0; kind < kinds; ++kind)
    result.control[kind] = stored_controls(curves.increments[kind], point.force_N, kind == 1);
  Eigen::Index at = 0;
  const auto parts = parts_of(bases.family);
  for (std::size_t i = kinds; i < parts.size(); ++i) {
    const int count = count_unknowns(parts[i]);
    result.control[i] = stored_part(parts[i], point, curves.more.segment(at, count), length_m);
    at += count;
  }

  add_uncertainty(point, rows, bases, plain, curves, length_m, result);
  result.score = score_point(samples, point, length_m, si, result.control, result.nuisance);
  result.is_scored = true;
  if (result.score.slipped_rows == 0 &&
      (kinds < kCurveKinds ? rows.drags > 0 : curves.is_identified[2]))
    add_sentence(curves.message, "no row slips in the fitted model: the limit curve is a guess");
  result.message = curves.message;
  result.status = curves.message.empty() ? FitStatus::good : FitStatus::underdetermined;
  if (result.score.relative > kPoorAbove) {
    if (result.status == FitStatus::good) result.status = FitStatus::poor;
    add_sentence(result.message, "residual is " + percent(result.score.relative) +
                                     " of the force, worst in experiment " +
                                     std::to_string(result.score.worst_experiment));
  }
  return result;
}

}  // namespace palpate::fit
