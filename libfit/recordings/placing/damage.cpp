#include <set>

#include "libfit/core/text.hpp"
#include "libfit/recordings/placing/place.hpp"

namespace palpate::recordings {
std::string break_note(const std::vector<Candidate>& candidates) {
  std::size_t recordings = 0;
  std::set<std::string> points;
  for (const Candidate& c : candidates)
    if (c.experiment >= 0 && c.recording->breaks) {
      ++recordings;
      points.insert(c.point);
    }
  if (recordings == 0) return {};
  return "the tool breaks in in " + counted(recordings, "recording", "recordings") + " at " +
         counted(points.size(), "point", "points") +
         "; deeper rows are no curve of the body and were left out";
}

Samples cycles_of(const std::vector<Candidate>& candidates,
                  const std::function<bool(const Candidate&)>& is_wanted) {
  Samples out;
  Eigen::Index rows = 0;
  std::vector<const Candidate*> used;
  for (const Candidate& c : candidates)
    if (c.experiment >= 0 && !c.aligned && c.recording->cycles.depth_m.size() > 0 && is_wanted(c)) {
      used.push_back(&c);
      rows += c.recording->cycles.depth_m.size();
    }
  out.deflection.resize(rows, 3);
  out.force.resize(rows, 3);
  out.torque = Points::Zero(rows, 3);
  out.force_error.resize(rows);
  Eigen::Index at = 0;
  std::int32_t experiment = 0;
  for (const Candidate* c : used) {
    const Conditioned& r = *c->recording;
    for (Eigen::Index i = 0; i < r.cycles.depth_m.size(); ++i, ++at) {
      out.point.push_back(c->point_index);
      out.experiment.push_back(experiment);
      out.kind.push_back(ExperimentKind::cycle);
      out.step.push_back(static_cast<std::int32_t>(i));
      out.status.push_back(RowStatus::good);
      out.deflection.row(at) = r.cycles.depth_m[i] * c->inward;
      out.force.row(at) = r.cycles.push_N[i] * c->inward;
      out.force_error[at] = r.cycles.error_N[i];
    }
    ++experiment;
  }
  return out;
}

}  // namespace palpate::recordings
