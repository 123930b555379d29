#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "libfit/core/node_forces.hpp"
#include "libfit/core/statistics.hpp"
#include "libfit/core/text.hpp"
#include "libfit/fit/fit_steps.hpp"

namespace palpate::fit {
namespace {

// Shares of what is expected beyond which a constant is far from it. Even blocks and livers stay
// within half of these, points above a lump do not.
constexpr double kFarLambda = 0.2, kFarFriction = 0.15, kFarFrictionSlope = 0.5;

constexpr double kApart = 0.05;   // of ln force: pairs that are closer tell no slope
constexpr double kSpread = 0.05;  // sum of squares at which a slope counts half

constexpr double kClear = 2;  // standard errors: what is nearer may be the same

bool is_far(double found, double expected, double share) {
  return std::abs(found - expected) > share * std::abs(expected);  // not from NaN
}

void warn_of(RingsReport& report, const char* what, double found, double expected,
             const char* why) {
  add_sentence(report.warning, fmt::format("{} {} is far from theory's {}{}", what, number(found),
                                           number(expected), why));
}

double constant_of(const FittedCurves& fitted, int part, Eigen::Index point) {
  return fitted.curves.control[part](point, 0);
}
double deviation_of(const FittedCurves& fitted, int part, Eigen::Index point) {
  return fitted.deviation[part].row(point).norm();
}

void compare_with_theory(const Samples& samples, RingsReport& report) {
  if (!std::isnan(samples.poisson))
    report.expected_lambda = options_for(samples).default_lateral_ratio;
  if (samples.probe) report.expected_friction = kSlidingShare * samples.probe->friction;
  if (const double radius_m = ball_radius_m(samples.probe); radius_m > 0)
    report.expected_friction_slope_1_m = report.friction / (2 * radius_m);

  if (is_far(report.lambda, report.expected_lambda, kFarLambda))
    warn_of(report, "lambda", report.lambda, report.expected_lambda,
            ": a lump, an anisotropy, a wrong Poisson's ratio, or a body that moves as a whole");
  if (is_far(report.friction, report.expected_friction, kFarFriction))
    warn_of(report, "mu0", report.friction, report.expected_friction,
            ": another friction than the probe's, or a body that moves as a whole");
  if (is_far(report.friction_slope_1_m, report.expected_friction_slope_1_m, kFarFrictionSlope))
    warn_of(
        report, "mu1 [1/m]", report.friction_slope_1_m, report.expected_friction_slope_1_m,
        ": drags at one depth alone, a tip that is no ball of that radius, or a body that moves "
        "as a whole");
}

// Of the points that were dragged, those whose lambda is far from the body's; they say so.
void find_uneven(const std::vector<std::size_t>& dragged, FittedCurves& fitted,
                 RingsReport& report) {
  for (const std::size_t p : dragged) {
    const double lambda = constant_of(fitted, runtime::kLambda, p);
    if (!is_far(lambda, report.lambda, kFarLambda) ||
        std::abs(lambda - report.lambda) < kClear * deviation_of(fitted, runtime::kLambda, p))
      continue;
    report.uneven.push_back(p);
    const std::string sentence =
        fmt::format("lambda {} is far from the body's {}: a lump or an anisotropy below",
                    number(lambda, 2), number(report.lambda, 2));
    if (fitted.message[p].find(sentence) == std::string::npos)  // a point that was kept has it
      add_sentence(fitted.message[p], sentence);
  }
}

}  // namespace

RingPoint ring_point(double log_force, const double* constant, const double* error) {
  RingPoint out{log_force};
  std::copy_n(constant, out.constant.size(), out.constant.begin());
  std::copy_n(error, out.error.size(), out.error.begin());
  out.error[0] /= out.constant[0];  // of the logarithm
  out.constant[0] = std::log(out.constant[0]);
  return out;
}

RingPrior ring_lines(const std::vector<RingPoint>& points, const RingConstants& deviation,
                     const std::optional<RingConstants>& theory) {
  RingPrior out;
  out.is_of_drags = true;
  out.deviation = deviation;
  std::vector<double> log_force;
  for (const RingPoint& point : points) log_force.push_back(point.log_force);
  out.log_force = median(log_force);
  for (std::size_t k = 0; k < deviation.size(); ++k) {
    // Weights in those of a point without error; over a point's variance.
    std::vector<double> weight, level, slopes, pair_weight;
    double square = 0;
    for (const RingPoint& point : points) {
      weight.push_back(1 / (1 + std::pow(point.error[k] / deviation[k], 2)));
      square += weight.back() * std::pow(point.log_force - out.log_force, 2);
    }
    for (std::size_t i = 0; i < points.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (const double apart = log_force[i] - log_force[j]; std::abs(apart) > kApart) {
          slopes.push_back((points[i].constant[k] - points[j].constant[k]) / apart);
          pair_weight.push_back(1 / (1 / weight[i] + 1 / weight[j]));
        }
    out.slope[k] = weighted_median(slopes, pair_weight) * square / (square + kSpread);
    for (const RingPoint& point : points)
      level.push_back(point.constant[k] - out.slope[k] * (point.log_force - out.log_force));
    out.constant[k] = weighted_median(level, weight);
    const double known = std::accumulate(weight.begin(), weight.end(), 0.0);
    if (theory) out.constant[k] += ((*theory)[k] - out.constant[k]) / (1 + known);
  }
  return out;
}

RingsReport judge_rings(const Samples& samples, const std::vector<CurveRows>& rows,
                        FittedCurves& fitted) {
  RingsReport report;
  if (fitted.curves.family != CurveFamily::rings) return report;
  // The body's constants are those of a point of median force.
  const NodeForces forces(fitted.curves);
  const double depth_m = fitted.curves.basis[0].knots_m.back();
  std::vector<std::size_t> dragged;
  std::vector<double> all_log_force;
  std::vector<RingPoint> points;
  std::array<std::vector<double>, 5> deviations;
  for (std::size_t p = 0; p < rows.size(); ++p) {
    if (fitted.status[p] == FitStatus::failed) continue;
    all_log_force.push_back(std::log(forces.normal_N(p, depth_m)));
    if (rows[p].drags == 0) continue;
    dragged.push_back(p);
    RingConstants constant{}, error{};
    for (int k = 0; k < 4; ++k) {
      constant[k] = constant_of(fitted, runtime::kLambda + k, p);
      error[k] = deviation_of(fitted, runtime::kLambda + k, p);
      deviations[k].push_back(error[k]);
    }
    points.push_back(ring_point(all_log_force.back(), constant.data(), error.data()));
    deviations[4].push_back(deviation_of(fitted, runtime::kSide2, p) * depth_m * depth_m /
                            std::exp(all_log_force.back()));
  }
  report.points = int(dragged.size());
  if (dragged.empty()) return report;
  RingConstants usual = kUsualRings;
  usual[2] /= depth_m;
  usual[3] /= depth_m;
  std::tie(report.lambda, report.friction, report.friction_slope_1_m, report.spread_1_m) =
      std::tuple_cat(ring_lines(points, usual).at(median(all_log_force)));
  report.lambda_deviation = median(deviations[0]);
  report.friction_deviation = median(deviations[1]);
  report.friction_slope_deviation_1_m = median(deviations[2]);
  report.spread_deviation_1_m = median(deviations[3]);
  report.side_deviation = median(deviations[4]);
  compare_with_theory(samples, report);
  find_uneven(dragged, fitted, report);
  return report;
}

}  // namespace palpate::fit
