#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"
#include "libfit/fit/fit_steps.hpp"

// Additions of recordings to a body's answer.

namespace palpate::fit {
namespace {

// Columns of each nuisance parameter in curves.h5.
constexpr struct {
  Eigen::VectorXd FittedRecordings::*value, FittedRecordings::*deviation;
} kColumns[kNuisances] = {
    {&FittedRecordings::contact_m, &FittedRecordings::contact_deviation_m},
    {&FittedRecordings::bias_N, &FittedRecordings::bias_deviation_N},
    {&FittedRecordings::drift_N, &FittedRecordings::drift_deviation_N},
};

void append(Eigen::VectorXd& column, double value) {
  column.conservativeResize(column.size() + 1);
  column[column.size() - 1] = value;
}

// A tool with less than this share of its force in slow motion has left the body.
constexpr double kLeastQuotient = 0.1;

// Rows of each experiment, one after the other, up to the first that is not good.
std::vector<std::vector<Eigen::Index>> usable_experiments(const Samples& samples) {
  std::vector<std::vector<Eigen::Index>> out;
  bool is_good = true;
  for (std::size_t row = 0; row < samples.status.size(); ++row) {
    if (row == 0 || samples.experiment[row] != samples.experiment[row - 1]) {
      out.emplace_back();
      is_good = true;
    }
    is_good = is_good && samples.status[row] == RowStatus::good;
    if (is_good) out.back().push_back(row);
  }
  return out;
}

// Normal forces of an experiment, in the samples' time or in slow motion.
std::vector<double> normal_forces(const Samples& samples, const std::vector<Eigen::Index>& rows,
                                  const Bases& bases, const CurveSet& curves) {
  const Eigen::Index point = samples.point[rows.front()];
  const Vec3 inward = samples.point_normal.row(point);
  const Points force =
      local_answer(curves_at(bases, curves, point, samples, point), samples, rows).force;
  std::vector<double> out;
  for (Eigen::Index i = 0; i < force.rows(); ++i) out.push_back(inward.dot(Vec3(force.row(i))));
  return out;
}

}  // namespace

void add_nuisances(const Samples& samples, const FitOptions& options, BodyData& body) {
  const bool frees_contact = options.estimates[kContact];
  const auto stated = contact_deviations_m(samples.recordings);
  if (frees_contact && stated.empty())
    throw Error("fit option estimates",
                "asks for contact points, but the samples state no deviation of any",
                "Say how far off each may be in recordings/contact_deviation of the samples.");
  for (PointData& point : body.points)
    for (PointExperiment& e : point.experiments) {
      if (frees_contact) {
        const auto found = stated.find(e.id);
        e.unknown[kContact] = found != stated.end() ? found->second / body.length_m : 0;
      }
      for (const int k : {kBias, kDrift})
        if (options.estimates[k]) e.unknown[k] = 0.05;  // of the point's typical force
    }
}

bool has_nuisances(const BodyData& body) {
  for (const PointData& point : body.points)
    for (const PointExperiment& e : point.experiments)
      if (is_any(e.unknown)) return true;
  return false;
}

PointData without_nuisances(PointData point, const std::vector<NuisanceValues>& nuisance) {
  point.depth = 0;
  for (std::size_t k = 0; k < nuisance.size(); ++k) {
    PointExperiment& e = point.experiments[k];
    for (std::size_t i = 0; i < e.row.size(); ++i) {
      e.deflection[i] += nuisance[k][kContact] * point.inward;
      e.force[i] -= sensor_reading(nuisance[k], place_in_recording(i, e.row.size())) * point.inward;
      point.depth = std::max(point.depth, depth_of(point, e.deflection[i]));
    }
  }
  return point;
}

FittedRecordings collect_nuisances(const BodyData& body, const std::vector<PointResult>& results) {
  FittedRecordings out;
  for (std::size_t p = 0; p < results.size(); ++p)
    for (std::size_t e = 0; e < results[p].nuisance.size(); ++e) {
      const NuisanceValues& deviation = results[p].nuisance_deviation[e];
      if (std::ranges::none_of(deviation, [](double d) { return d > 0; })) continue;
      out.experiment.push_back(body.points[p].experiments[e].id);
      out.point.push_back(p);
      for (int k = 0; k < kNuisances; ++k) {
        append(out.*kColumns[k].value, results[p].nuisance[e][k]);
        append(out.*kColumns[k].deviation, deviation[k]);
      }
    }
  return out;
}

Samples in_slow_motion(const Samples& timed, const FittedCurves& curves) {
  Samples out = timed;
  out.time_s.resize(0);
  const Bases bases = bases_of(curves.curves);
  for (const std::vector<Eigen::Index>& rows : usable_experiments(timed)) {
    if (rows.empty()) continue;
    const std::int32_t point = timed.point[rows.front()];
    if (curves.status[point] == FitStatus::failed) continue;
    const auto fast = normal_forces(timed, rows, bases, curves.curves),
               slow = normal_forces(out, rows, bases, curves.curves);
    // Below it a quotient is that of the next row above.
    const double least = 0.02 * *std::ranges::max_element(slow);
    std::vector<double> quotient;
    for (std::size_t i = 0; i < slow.size(); ++i)
      quotient.push_back(slow[i] > least && slow[i] > 0 ? fast[i] / slow[i] : 0);
    const auto first = std::ranges::find_if(quotient, [](double q) { return q > kLeastQuotient; });
    double before = first != quotient.end() ? *first : 1, deepest_m = 0;
    const bool is_press = timed.kind[rows.front()] == ExperimentKind::press;
    for (std::size_t i = 0; i < slow.size(); ++i) {
      const Eigen::Index row = rows[i];
      const bool is_significant = slow[i] > least && slow[i] > 0;
      const double depth_m = timed.deflection.row(row).dot(timed.point_normal.row(point));
      deepest_m = std::max(deepest_m, depth_m);
      // Unloading releases rings one by one, a body does not.
      const bool is_unloading = is_press && depth_m < 0.98 * deepest_m;
      if (is_unloading || (is_significant && quotient[i] < kLeastQuotient)) {
        out.status[row] = RowStatus::no_contact;
        continue;
      }
      if (is_significant) before = quotient[i];
      out.force.row(row) /= before;
      out.torque.row(row) /= before;
      out.force_error[row] /= before;
    }
  }
  return out;
}

FitOptions as_before(FitOptions options) {
  const CurveSet& curves = options.warm_start->curves;
  options.degree = curves.basis[0].degree;
  for (std::size_t kind = 0; kind < curves_of(curves.family); ++kind) {
    if (curves.basis[kind].degree != options.degree)
      throw Error("warm start", "has curves of several degrees", "Fit without a warm start.");
    options.knots_m[kind] = curves.basis[kind].knots_m;
  }
  options.family = curves.family;
  options.sways = curves.family == CurveFamily::rings && !curves.control[runtime::kSway].isZero(0);
  return options;
}

}  // namespace palpate::fit
