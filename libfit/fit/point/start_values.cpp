#include "libfit/fit/point/point.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "libfit/core/text.hpp"
#include "libfit/fit/point/replay.hpp"
#include "libfit/runtime/law/response.hpp"

namespace palpate::fit {
namespace {

// Smallest slope of f^r, of its mean slope: strictly increasing through rounding to float32 (6e-8),
// and a slip's root always exists.
constexpr double kLateralSlopeFloor = 1e-4;
constexpr double kHoldMargin = 1.05;  // a limit made up exceeds every recorded lateral force by 5 %

// Slope of the straight line through zero nearest to the rows.
double line_slope(const std::vector<CurveRow>& rows) {
  double cross = 0, square = 0;
  for (const CurveRow& row : rows) {
    cross += row.weight * row.weight * row.x * row.f;
    square += row.weight * row.weight * row.x * row.x;
  }
  return square > 0 ? cross / square : 0;
}

int count_groups(const std::vector<CurveRow>& rows) {
  return rows.empty() ? 0 : rows.back().group + 1;  // sorted by choose_bases
}

void start_normal(const CurveRows& rows, const CurveBasis& basis, PointCurves& out) {
  const auto& data = rows.curve[0];
  out.lower[0] = Eigen::VectorXd::Zero(basis.size() - 1);
  const double slope = line_slope(data);
  if (!(slope > 0)) {
    out.problem = "no row with the probe in the body and a force into it";
    return;
  }
  if (data.size() <= 2 || count_groups(data) < 2) {
    out.increments[0] = slope * greville_steps(basis);
    add_sentence(out.message, (data.size() <= 2 ? std::to_string(data.size()) + " row(s) in contact"
                                                : "all rows at one depth") +
                                  ": the normal curve is a straight line");
    return;
  }
  out.weak_prior[0] = smoothness_prior(basis);
  out.increments[0] = fit_increments(basis, unit_weights(data), out.lower[0], out.weak_prior[0]);
  out.is_identified[0] = true;
  if (!(out.increments[0].sum() > 0)) out.problem = "no rising curve fits the rows";
}

void start_lateral(const PointData& point, const CurveRows& rows, const CurveBasis& normal,
                   const CurveBasis& basis, const FitOptions& options, PointCurves& out) {
  const auto& data = rows.curve[1];
  double slope = line_slope(data);
  if (data.empty() || !(slope > 0)) {
    slope = options.default_lateral_ratio * curve_at(normal, out.increments[0], point.depth) /
            point.depth;
    std::string sentence = "the lateral curve is a line of " +
                           number(options.default_lateral_ratio) +
                           " of the normal stiffness at full depth";
    if (rows.slipping_drags > 0 && rows.lateral_reach > 0) {
      double limit = 0;  // every slipping row must go on slipping
      for (const CurveRow& row : rows.curve[2]) limit = std::max(limit, row.f);
      if (slope * rows.lateral_reach < kHoldMargin * limit) {
        slope = kHoldMargin * limit / rows.lateral_reach;
        sentence = "the lateral curve is the softest line on which all of them slip";
      }
      add_sentence(out.message, "no row sticks: " + sentence);
    } else if (rows.drags > 0) {
      add_sentence(out.message, "no lateral force: " + sentence);
    }
    out.increments[1] = slope * greville_steps(basis);
    out.lower[1] = kLateralSlopeFloor * out.increments[1];
    return;
  }
  out.lower[1] = kLateralSlopeFloor * slope * greville_steps(basis);
  out.weak_prior[1] = smoothness_prior(basis);
  out.increments[1] = fit_increments(basis, unit_weights(data), out.lower[1], out.weak_prior[1]);
  out.is_identified[1] = true;
  if (data.size() <= 2)
    add_sentence(out.message,
                 std::to_string(data.size()) + " row(s) stick: the lateral curve is nearly a line");
}

void start_limit(const CurveRows& rows, const CurveBasis& normal, const CurveBasis& basis,
                 const FitOptions& options, PointCurves& out) {
  const auto& data = rows.curve[2];
  out.lower[2] = Eigen::VectorXd::Zero(basis.size() - 1);
  out.friction = median_ratio(data, normal, out.increments[0]);
  if (!(out.friction > 0)) {
    out.friction = std::max(options.default_friction, kHoldMargin * rows.largest_friction);
    out.increments[2] = transfer(normal, out.increments[0], basis, out.friction);
    if (rows.drags > 0)
      add_sentence(out.message,
                   "no row slips: the limit is " + number(out.friction) + " of the normal force" +
                       (out.friction > options.default_friction ? ", just above what held" : ""));
    return;
  }
  out.weak_prior[2] = value_prior(transfer(normal, out.increments[0], basis, out.friction));
  out.increments[2] = fit_increments(basis, unit_weights(data), out.lower[2], out.weak_prior[2]);
  out.is_identified[2] = true;
}

// g_2 and g_3 along the tangents that best fit the lateral force of presses.
Eigen::Vector4d start_side(const PointData& point) {
  const auto tangents = tangents_of(point.inward);
  Eigen::Matrix2d square = kWeakPrior * Eigen::Matrix2d::Identity(),
                  right = Eigen::Matrix2d::Zero();
  for (const PointExperiment& e : point.experiments) {
    if (e.is_replayed) continue;
    for (std::size_t i = 0; i < e.row.size(); ++i) {
      const double d = depth_of(point, e.deflection[i]);
      if (!(d > 0)) continue;
      const Eigen::Vector2d w(d * d, d * d * d);
      square += w * w.transpose();
      for (int k = 0; k < 2; ++k) right.col(k) += w * e.force[i].dot(tangents[k]);
    }
  }
  const Eigen::Matrix2d g = square.ldlt().solve(right);  // a row each
  return {g(0, 0), g(0, 1), g(1, 0), g(1, 1)};
}

void start_rings(const PointData& point, const CurveRows& rows, const CurveBasis& normal,
                 const RingPrior& prior, PointCurves& out) {
  // Lambda is 3.5 to 4.3 on a bowel, whose wall dents by bending and stretches aside. Its forces
  // are off by 10.9 % (p95) with half of kMost, by 2.8 with this and by 2.6 with twice that.
  constexpr double kLeastLambda = 0.05, kMost = 6, kMostSide = 10;
  const double most_side = prior.has_side ? kMostSide : 1e-9;
  out.log_force =
      std::log(point.force_N * curve_at(normal, out.increments[0], normal.knots_m.back()));
  const auto [lambda, friction, friction_slope, spread] = prior.at(out.log_force);
  out.constants.resize(8);
  out.constants << std::clamp(lambda, kLeastLambda, kMost), std::min(friction, kMost),
      std::clamp(friction_slope, -0.5 * friction, kMost), std::min(spread, kMost),
      prior.has_side ? start_side(point) : Eigen::Vector4d::Zero();
  out.constants_expected = out.constants;
  out.constants_expected.tail<4>().setZero();
  out.constants_deviation.resize(8);
  out.constants_deviation << Eigen::Map<const Eigen::Vector4d>(prior.deviation.data()),
      Eigen::Vector4d::Ones();
  // A press on a body that sways moves sideways, too, but by what the sway is known to: without
  // drags lambda and the friction stay the body's.
  if (rows.drags == 0) out.constants_deviation.head<4>() *= 1e-3;
  out.constants_lower.resize(8);
  out.constants_lower << kLeastLambda, 0, -0.5 * friction, 0, Eigen::Vector4d::Constant(-most_side);
  out.constants_upper.resize(8);
  out.constants_upper << kMost, kMost, kMost, prior.has_spread() ? kMost : 1e-9,
      Eigen::Vector4d::Constant(most_side);
}

}  // namespace

PointCurves start_values(const PointData& point, const CurveRows& rows, const BodyBases& body,
                         const FitOptions& options) {
  const std::vector<CurveBasis>& bases = body.plain;
  PointCurves out;
  out.nuisance.resize(point.experiments.size());
  start_normal(rows, bases[0], out);
  if (!out.problem.empty()) return out;
  if (body.family == CurveFamily::rings) {
    start_rings(point, rows, bases[0], body.rings, out);
    return out;
  }
  start_lateral(point, rows, bases[0], bases[1], options, out);
  start_limit(rows, bases[0], bases[2], options, out);
  return out;
}

}  // namespace palpate::fit
