#include <algorithm>
#include <cmath>
#include <map>

#include "libfit/core/text.hpp"
#include "libfit/recordings/placing/place.hpp"

namespace palpate::recordings {
namespace {

struct MeanAndDeviation {
  double mean = 0, deviation = std::numeric_limits<double>::quiet_NaN();
};
MeanAndDeviation spread_of(const std::vector<double>& values) {
  MeanAndDeviation out;
  const auto n = static_cast<double>(values.size());
  for (const double value : values) out.mean += value / n;
  if (values.size() < 2) return out;
  double squares = 0;
  for (const double value : values) squares += (value - out.mean) * (value - out.mean);
  out.deviation = std::sqrt(squares / (n - 1));
  return out;
}

}  // namespace

std::optional<BodyPuncture> puncture_of(const std::vector<Candidate>& candidates) {
  std::map<std::string, std::vector<double>> force_N;
  std::vector<double> depth_m;
  for (const Candidate& c : candidates)
    if (c.experiment >= 0 && std::isfinite(c.recording->puncture_N)) {
      force_N[c.point].push_back(c.recording->puncture_N);
      depth_m.push_back(c.recording->puncture_depth_m);
    }
  if (force_N.empty()) return std::nullopt;
  BodyPuncture out;
  std::vector<double> means;
  for (const auto& [point, values] : force_N) {
    const MeanAndDeviation spread = spread_of(values);
    out.points.push_back({point, values.size(), spread.mean, spread.deviation});
    means.push_back(spread.mean);
    out.recordings += values.size();
  }
  const MeanAndDeviation over = spread_of(means);
  out.force_N = over.mean;
  out.deviation_N = over.deviation;
  out.depth_m = spread_of(depth_m).mean;
  return out;
}

std::string puncture_note(const BodyPuncture& found) {
  const auto plural = [](std::size_t n, const char* word) {
    return counted(n, word, std::string(word) + "s");
  };
  std::string note = "the tool breaks in in " + plural(found.recordings, "recording") + " at " +
                     plural(found.points.size(), "point") + ", at " + number(found.force_N) +
                     " N and " + millimetres(found.depth_m) + " (means); ";
  if (std::isfinite(found.deviation_N))
    note += "points deviate by " + number(found.deviation_N) + " N; ";
  double largest = std::numeric_limits<double>::quiet_NaN();
  for (const BodyPuncture::PuncturedPoint& point : found.points)
    if (!(point.deviation_N <= largest) && std::isfinite(point.deviation_N))
      largest = point.deviation_N;
  if (std::isfinite(largest)) note += "repeats of a point by up to " + number(largest) + " N; ";
  return note +
         "deeper rows are no curve of the body and were left out. An asset breaks with "
         "puncture_force of [export], or `export --puncture-force`";
}

Samples cycles_of(const std::vector<Candidate>& candidates, const Samples& samples) {
  Samples out;
  out.point_position = samples.point_position;
  out.point_normal = samples.point_normal;
  out.point_name = samples.point_name;
  Eigen::Index rows = 0;
  std::vector<const Candidate*> used;
  for (const Candidate& c : candidates)
    if (c.experiment >= 0 && !c.aligned && c.recording->cycle_depth_m.size() > 0) {
      used.push_back(&c);
      rows += c.recording->cycle_depth_m.size();
    }
  out.deflection.resize(rows, 3);
  out.force.resize(rows, 3);
  out.torque = Points::Zero(rows, 3);
  out.force_error.resize(rows);
  Eigen::Index at = 0;
  std::int32_t experiment = 0;
  for (const Candidate* c : used) {
    const Conditioned& r = *c->recording;
    for (Eigen::Index i = 0; i < r.cycle_depth_m.size(); ++i, ++at) {
      out.point.push_back(c->point_index);
      out.experiment.push_back(experiment);
      out.kind.push_back(ExperimentKind::path);
      out.step.push_back(static_cast<std::int32_t>(i));
      out.status.push_back(RowStatus::good);
      out.deflection.row(at) = r.cycle_depth_m[i] * c->inward;
      out.force.row(at) = r.cycle_push_N[i] * c->inward;
      out.force_error[at] = r.cycle_error_N[i];
    }
    ++experiment;
  }
  return out;
}

}  // namespace palpate::recordings
