#include "libfit/fit/point/nuisance.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "libfit/core/error.hpp"

namespace palpate::fit {
namespace {

constexpr double kSensorDeviation = 0.05;  // of bias and drift, over the point's typical force

// Standard deviation of each experiment's contact point [m]: that of the mean of its recordings.
std::map<std::int32_t, double> stated_deviations(const MeasuredRecordings& recordings) {
  std::map<std::int32_t, std::pair<double, double>> sums;  // of squares, count
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const double deviation = recordings.contact_deviation_m[static_cast<Eigen::Index>(i)];
    if (!(deviation > 0) || !std::isfinite(deviation)) continue;
    auto& [square, count] = sums[recordings.experiment[i]];
    square += deviation * deviation, ++count;
  }
  std::map<std::int32_t, double> out;
  for (const auto& [experiment, sum] : sums) out[experiment] = std::sqrt(sum.first) / sum.second;
  return out;
}

void append(Eigen::VectorXd& column, double value) {
  column.conservativeResize(column.size() + 1);
  column[column.size() - 1] = value;
}

}  // namespace

void add_nuisances(const Samples& samples, const FitOptions& options, BodyData& body) {
  const bool frees_contact = options.estimates[static_cast<std::size_t>(Nuisance::contact)];
  const auto stated = stated_deviations(samples.recordings);
  if (frees_contact && stated.empty())
    throw Error("fit option estimates",
                "asks for contact points, but the samples state no deviation of any",
                "Say how far off each may be in recordings/contact_deviation of the samples.");
  for (PointData& point : body.points)
    for (PointExperiment& e : point.experiments) {
      if (frees_contact) {
        const auto found = stated.find(e.id);
        e.unknown.contact = found != stated.end() ? found->second / body.length_m : 0;
      }
      if (options.estimates[static_cast<std::size_t>(Nuisance::bias)])
        e.unknown.bias = kSensorDeviation;
      if (options.estimates[static_cast<std::size_t>(Nuisance::drift)])
        e.unknown.drift = kSensorDeviation;
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
      e.deflection[i] += nuisance[k].contact * point.inward;
      e.force[i] -= nuisance[k].reading(part_of_way(i, e.row.size())) * point.inward;
      point.depth = std::max(point.depth, depth_of(point, e.deflection[i]));
    }
  }
  return point;
}

FittedRecordings collect_nuisances(const BodyData& body, const std::vector<PointResult>& results) {
  FittedRecordings out;
  for (std::size_t p = 0; p < results.size(); ++p)
    for (std::size_t e = 0; e < results[p].nuisance.size(); ++e) {
      const NuisanceValues& value = results[p].nuisance[e];
      const NuisanceValues& deviation = results[p].nuisance_deviation[e];
      if (!(deviation.contact > 0 || deviation.bias > 0 || deviation.drift > 0)) continue;
      out.experiment.push_back(body.points[p].experiments[e].id);
      out.point.push_back(static_cast<std::int32_t>(p));
      append(out.contact_m, value.contact), append(out.contact_deviation_m, deviation.contact);
      append(out.bias_N, value.bias), append(out.bias_deviation_N, deviation.bias);
      append(out.drift_N, value.drift), append(out.drift_deviation_N, deviation.drift);
    }
  return out;
}

void restore_nuisances(const FittedRecordings& earlier, Eigen::Index point, std::size_t experiments,
                       PointResult& result) {
  for (std::size_t i = 0; i < earlier.point.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    if (earlier.point[i] != point) continue;
    result.nuisance.push_back({earlier.contact_m[at], earlier.bias_N[at], earlier.drift_N[at]});
    result.nuisance_deviation.push_back({earlier.contact_deviation_m[at],
                                         earlier.bias_deviation_N[at],
                                         earlier.drift_deviation_N[at]});
  }
  if (result.nuisance.size() == experiments) return;  // else an earlier fit that knew them all
  result.nuisance.clear(), result.nuisance_deviation.clear();
}

}  // namespace palpate::fit
