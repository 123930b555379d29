#include "libfit/recordings/placing/assemble.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "libfit/core/experiments.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/core/text.hpp"
#include "libfit/recordings/batch/plausible.hpp"
#include "libfit/recordings/placing/place.hpp"

namespace palpate::recordings {
namespace {

std::vector<PlacedRecording> candidates_of(const std::vector<BatchItem>& items,
                                           const std::vector<ItemResult>& results) {
  std::vector<PlacedRecording> candidates;
  const auto questions = question_stiffness(items, results);
  for (std::size_t i = 0; i < results.size(); ++i) {
    for (std::size_t k = 0; k < results[i].recordings.size(); ++k) {
      PlacedRecording& c = candidates.emplace_back();
      c.item = i;
      c.recording = &results[i].recordings[k];
      c.name = c.recording->name;
      c.point = point_of(items[i], c.name);
      c.failure = questions[i][k];
    }
    for (const Refused& r : results[i].refused) {
      PlacedRecording& c = candidates.emplace_back();
      c.item = i;
      c.refused = &r;
      c.name = r.name;
      c.point = items[i].point;
      c.failure = r.failure;
    }
  }
  return candidates;
}

// Points by name, in the order in which they first come; a member elsewhere is refused.
std::vector<std::vector<std::size_t>> group_by_point(const std::vector<BatchItem>& items,
                                                     const AssembleOptions& options,
                                                     std::vector<PlacedRecording>& candidates) {
  std::vector<std::vector<std::size_t>> points;
  std::map<std::string, std::size_t> index;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    PlacedRecording& c = candidates[i];
    if (c.failure) continue;
    const auto [at, is_new] = index.emplace(c.point, points.size());
    if (is_new) points.emplace_back();
    auto& members = points[at->second];
    if (!members.empty() &&
        (candidates[members[0]].position_m - c.position_m).norm() > options.place_tolerance_m) {
      c.failure = Failure{items[c.item].file.string(),
                          "lies elsewhere than " + shown(items, candidates[members[0]]) +
                              ", the first recording of point `" + c.point + "`",
                          "Give it a point of its own, or correct its position."};
      continue;
    }
    c.point_index = static_cast<std::int32_t>(at->second);
    members.push_back(i);
  }
  return points;
}

// Each tip of known size with how many recordings it made, most first.
std::vector<UsedTip> tips_of(const std::vector<BatchItem>& items,
                             const std::vector<PlacedRecording>& candidates) {
  std::vector<std::pair<UsedTip, std::size_t>> counts;
  for (const PlacedRecording& c : candidates) {
    const UsedTip tip = tip_of(items, c);
    if (c.failure || !(tip.radius_m > 0)) continue;
    const auto at = std::ranges::find(counts, tip, &std::pair<UsedTip, std::size_t>::first);
    if (at == counts.end())
      counts.emplace_back(tip, 1);
    else
      ++at->second;
  }
  std::stable_sort(counts.begin(), counts.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  std::vector<UsedTip> out;
  for (const auto& [tip, count] : counts) out.push_back(tip);
  return out;
}

// The number of the tip that made a recording; 0 where it is not known.
std::int32_t tip_number(const std::vector<UsedTip>& tips, const std::vector<BatchItem>& items,
                        const PlacedRecording& c) {
  const auto at = std::ranges::find(tips, tip_of(items, c));
  return at == tips.end() ? 0 : static_cast<std::int32_t>(at - tips.begin());
}

// Recordings of each point, those of each tip by themselves: they have one curve.
std::vector<std::vector<std::size_t>> by_tip(const std::vector<std::vector<std::size_t>>& points,
                                             const std::vector<UsedTip>& tips,
                                             const std::vector<BatchItem>& items,
                                             const std::vector<PlacedRecording>& candidates) {
  std::vector<std::vector<std::size_t>> out;
  for (const auto& members : points) {
    std::map<std::int32_t, std::vector<std::size_t>> of_tip;
    for (const std::size_t m : members) of_tip[tip_number(tips, items, candidates[m])].push_back(m);
    for (auto& [number, of_one] : of_tip) out.push_back(std::move(of_one));
  }
  return out;
}

// Rows of an experiment, and where in the samples they go.
struct NumberedRows {
  ExperimentRows rows;
  std::int32_t point = 0, experiment = 0, probe = 0;
  ExperimentKind kind = ExperimentKind::press;
};

// Fills in the rows; probe numbers where any is wanted.
void fill_rows(const std::vector<NumberedRows>& parts, bool has_probes, Samples& samples) {
  Eigen::Index rows = 0;
  for (const NumberedRows& part : parts) rows += part.rows.force_N.rows();
  samples.deflection.resize(rows, 3);
  samples.force.resize(rows, 3);
  samples.force_error.resize(rows);
  samples.torque = Points::Zero(rows, 3);
  const bool has_time =
      std::ranges::all_of(parts, [](const NumberedRows& p) { return p.rows.time_s.size() > 0; });
  samples.time_s.resize(has_time ? rows : 0);
  Eigen::Index at = 0;
  for (const auto& [from, point, experiment, probe, kind] : parts) {
    const Eigen::Index n = from.force_N.rows();
    for (Eigen::Index i = 0; i < n; ++i) {
      samples.point.push_back(point);
      samples.experiment.push_back(experiment);
      samples.kind.push_back(kind);
      if (has_probes) samples.probe_number.push_back(probe);
      samples.step.push_back(static_cast<std::int32_t>(i));
    }
    samples.status.insert(samples.status.end(), from.status.begin(), from.status.end());
    samples.deflection.middleRows(at, n) = from.deflection_m;
    samples.force.middleRows(at, n) = from.force_N;
    samples.force_error.segment(at, n) = from.error_N;
    if (from.torque_Nm.rows() == n) samples.torque.middleRows(at, n) = from.torque_Nm;
    if (has_time) samples.time_s.segment(at, n) = from.time_s;
    at += n;
  }
}

// Rows of every tip but the first are of the kind `other`, once it does not matter that they press.
void name_others(Samples& samples) {
  for (std::size_t i = 0; i < samples.probe_number.size(); ++i)
    if (samples.probe_number[i] > 0) samples.kind[i] = ExperimentKind::other;
}

MeasuredRecordings provenance(const std::vector<BatchItem>& items,
                              const std::vector<ItemResult>& results,
                              const std::vector<PlacedRecording>& candidates) {
  MeasuredRecordings out;
  std::vector<const PlacedRecording*> used;
  for (const PlacedRecording& c : candidates)
    if (c.experiment >= 0) used.push_back(&c);
  const Eigen::Index n = used.size();
  for (Eigen::VectorXd* column : {&out.contact_m, &out.contact_deviation_m, &out.speed_m_s,
                                  &out.noise_N, &out.hysteresis, &out.young_Pa})
    column->resize(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const PlacedRecording& c = *used[i];
    const Conditioned& r = *c.recording;
    out.experiment.push_back(c.experiment);
    out.file.push_back(shown(items, c));
    out.hash.push_back(results[c.item].hash);
    const FoundContact contact = contact_of(c);
    out.contact_m[i] = contact.travel_m;
    out.contact_deviation_m[i] = contact.deviation_m;
    out.estimator.push_back(contact.estimator);
    out.speed_m_s[i] = r.speed_m_s;
    out.noise_N[i] = r.noise_N;
    out.hysteresis[i] = r.hysteresis;
    out.young_Pa[i] = r.young_Pa;
    out.grade.push_back(static_cast<std::int8_t>(r.grade));
    std::string reasons;
    for (const std::string& reason : r.reasons) reasons += (reasons.empty() ? "" : "; ") + reason;
    out.reasons.push_back(reasons);
  }
  return out;
}

constexpr const char* kNoClock =
    "some recordings have no clock: rows hold no time, and a fit takes their forces for those of "
    "slow motion";

std::string sideways_note(const Samples& samples, const std::vector<std::int32_t>& experiments) {
  std::vector<std::string> points;
  for (const std::int32_t e : experiments) {
    const auto at = std::ranges::find(samples.experiment, e) - samples.experiment.begin();
    points.push_back(samples.point_name[samples.point[at]]);
  }
  return "presses that move sideways by more than a third of their depth, and feel it, count as "
         "drags; say kind = \"drag\" of them, or correct the normal: " +
         listed(points);
}

// Every recording an experiment of its own, in time, contacts of what is alike aligned; nothing
// where one has no clock.
std::optional<std::vector<std::vector<Pooled>>> experiments_in_time(
    std::vector<PlacedRecording>& candidates, const std::vector<std::vector<std::size_t>>& points,
    const std::vector<std::vector<std::size_t>>& alike, const std::vector<BatchItem>& items,
    const RelaxationFit& body) {
  for (const auto& members : points)
    for (const std::size_t m : members)
      if (!in_time(candidates, m)) return std::nullopt;
  align_points(candidates, alike, items, body);
  std::vector<std::vector<Pooled>> experiments;
  for (const auto& members : points) {
    experiments.emplace_back();
    for (const std::size_t m : members) experiments.back().push_back(*in_time(candidates, m));
  }
  return experiments;
}

// A sentence on recordings in which the tool broke in; empty where it did in none.
std::string break_note(const std::vector<PlacedRecording>& candidates) {
  std::size_t recordings = 0;
  std::set<std::string> points;
  for (const PlacedRecording& c : candidates)
    if (c.experiment >= 0 && c.recording->breaks) {
      ++recordings;
      points.insert(c.point);
    }
  if (recordings == 0) return {};
  return "the tool breaks in in " + counted(recordings, "recording", "recordings") + " at " +
         counted(points.size(), "point", "points") +
         "; deeper rows are no curve of the body and were left out";
}

// Presses in cycles of the first tip, whose curves damage is of, without the places that they are
// at; no rows where there are none.
Samples cycles_of(const std::vector<PlacedRecording>& candidates, const std::vector<UsedTip>& tips,
                  const std::vector<BatchItem>& items) {
  std::vector<NumberedRows> parts;
  for (const PlacedRecording& c : candidates) {
    if (c.experiment < 0 || c.aligned || tip_number(tips, items, c) != 0) continue;
    const CycleMeans& cycles = c.recording->cycles;
    if (cycles.depth_m.size() == 0) continue;
    NumberedRows& part = parts.emplace_back();
    part.point = c.point_index;
    part.experiment = static_cast<std::int32_t>(parts.size() - 1);
    part.kind = ExperimentKind::cycle;
    part.rows.deflection_m = cycles.depth_m * c.inward.transpose();
    part.rows.force_N = cycles.push_N * c.inward.transpose();
    part.rows.error_N = cycles.error_N;
    part.rows.status.assign(cycles.depth_m.size(), RowStatus::good);
  }
  Samples out;
  fill_rows(parts, false, out);
  return out;
}

}  // namespace

std::size_t Assembled::failed() const {
  return std::ranges::count_if(outcomes,
                               [](const PlacedRecording& o) { return o.failure.has_value(); });
}

Assembled assemble(const std::vector<BatchItem>& items, const std::vector<ItemResult>& results,
                   const AssembleOptions& options) {
  Assembled out;
  out.outcomes = candidates_of(items, results);
  std::vector<PlacedRecording>& candidates = out.outcomes;
  out.registration = place_on_body(items, options, candidates);
  const auto points = group_by_point(items, options, candidates);
  out.tips = tips_of(items, candidates);
  const auto alike = by_tip(points, out.tips, items, candidates);

  Samples& samples = out.samples;
  samples.point_position.resize(points.size(), 3);
  samples.point_normal.resize(points.size(), 3);
  std::vector<std::vector<Pooled>> experiments;
  for (const auto& members : points) experiments.push_back(pool(candidates, members, items));
  if (options.relaxation != RelaxationUse::none) {
    const TimedPoints timed = presses_in_time(candidates, alike, items);
    if (!timed.member.empty()) out.relaxation = relaxation_of(candidates, timed, items);
  }
  const bool relaxes =
      out.relaxation && out.relaxation->fit.relaxation.branches() > 0 &&
      (out.relaxation->doubts.empty() || options.relaxation == RelaxationUse::always);
  if (relaxes) {
    out.relaxation->is_applied = true;
    samples.relaxation = out.relaxation->fit.relaxation;
    if (auto timed = experiments_in_time(candidates, points, alike, items, out.relaxation->fit))
      experiments = std::move(*timed);
    else
      out.notes.push_back(kNoClock);
  }
  std::vector<NumberedRows> parts;
  for (std::size_t p = 0; p < points.size(); ++p) {
    const PlacedRecording& first = candidates[points[p][0]];
    samples.point_position.row(p) = first.position_m;
    samples.point_normal.row(p) = first.inward;
    samples.point_name.push_back(first.point);
    for (const Pooled& pooled : experiments[p]) {
      const PlacedRecording& one = candidates[pooled.member[0]];
      const auto number = static_cast<std::int32_t>(parts.size());
      parts.push_back({pooled, static_cast<std::int32_t>(p), number,
                       tip_number(out.tips, items, one), items[one.item].signal.kind});
      for (const std::size_t m : pooled.member) candidates[m].experiment = number;
    }
    if (relaxes) continue;  // what the rates do is fitted
    const auto notes = compare_rates(first.point, experiments[p], candidates, items);
    out.notes.insert(out.notes.end(), notes.begin(), notes.end());
  }
  if (const std::string note = break_note(candidates); !note.empty())
    out.notes.insert(out.notes.begin(), note);
  const auto copies = copy_notes(items, results);
  out.notes.insert(out.notes.begin(), copies.begin(), copies.end());
  if (out.relaxation) {
    const auto found = relaxation_notes(*out.relaxation);
    out.notes.insert(out.notes.begin(), found.begin(), found.end());
  }
  fill_rows(parts, true, samples);
  remove_void_columns(samples);
  samples = joined(samples, cycles_of(candidates, out.tips, items));
  if (const auto sideways = straighten_presses(samples); !sideways.empty())
    out.notes.push_back(sideways_note(samples, sideways));
  name_others(samples);
  samples.recordings = provenance(items, results, candidates);
  return out;
}

}  // namespace palpate::recordings
