#include "libfit/fit/fit_point.hpp"

#include "libfit/fit/solve_point.hpp"
#include "libfit/fit/words.hpp"

namespace palpate::fit {
PointResult no_curves(const BodyBases& bases, const std::string& why) {
  PointResult result;
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind)
    result.control[kind] = Eigen::VectorXd::Zero(bases.si[kind].size());
  if (!bases.lean_si.knots_m.empty())
    result.lean_m = Eigen::VectorXd::Zero(3 * bases.lean_si.size());
  result.message = why;
  return result;
}

PointCurves identify(const PointData& point, const PointRows& rows, const BodyBases& bases,
                     const Bases& plain, const FitOptions& options) {
  PointCurves curves = start_values(point, rows, bases.plain, bases.lean_plain, options);
  if (!curves.problem.empty()) return curves;
  solve_point(point, plain, options, curves);
  if (!curves.is_identified[2])  // made up from f^z, which may have moved
    curves.increments[2] =
        transfer(bases.plain[0], curves.increments[0], bases.plain[2], curves.friction);
  return curves;
}

PointResult fit_point(const Samples& samples, const PointData& point, const PointRows& rows,
                      double length_m, const BodyBases& bases, const Bases& plain, const Bases& si,
                      const FitOptions& options) {
  PointResult result = no_curves(bases, point.problem);
  if (!point.problem.empty()) return result;
  PointCurves curves = identify(point, rows, bases, plain, options);
  result.message = curves.problem;
  if (!curves.problem.empty()) return result;
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind)
    result.control[kind] = stored_controls(curves.increments[kind], point.force_N, kind == 1);
  result.lean_m = stored_lean(point.inward, curves.lean, length_m);

  result.score = score_point(samples, point, length_m, si, result.control, result.lean_m);
  result.is_scored = true;
  if (curves.is_identified[2] && result.score.slipped_rows == 0)
    add_sentence(curves.message, "no row slips in the fitted model: the limit curve is a guess");
  result.message = curves.message;
  result.status = curves.message.empty() ? FitStatus::good : FitStatus::underdetermined;
  if (result.score.relative > options.poor_above) {
    if (result.status == FitStatus::good) result.status = FitStatus::poor;
    add_sentence(result.message, "residual is " + percent(result.score.relative) +
                                     " of the force, worst in experiment " +
                                     std::to_string(result.score.worst_experiment));
  }
  return result;
}

PointResult keep_point(const Samples& samples, const PointData& point, double length_m,
                       const Bases& si, const FittedCurves& earlier, Eigen::Index row) {
  PointResult result;
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind)
    result.control[kind] = earlier.curves.control[kind].row(row);
  if (earlier.curves.lean.size() > 0) result.lean_m = earlier.curves.lean.row(row);
  result.status = earlier.status[static_cast<std::size_t>(row)];
  result.message = earlier.message[static_cast<std::size_t>(row)];
  result.is_kept = true;
  result.is_scored = result.status != FitStatus::failed;
  if (result.is_scored)
    result.score = score_point(samples, point, length_m, si, result.control, result.lean_m);
  return result;
}

}  // namespace palpate::fit
