#include "libfit/recordings/placing/assemble.hpp"

#include <algorithm>
#include <functional>
#include <iterator>
#include <map>
#include <set>

#include "libfit/core/experiments.hpp"
#include "libfit/core/text.hpp"

namespace palpate::recordings {
namespace {

std::vector<PlacedRecording> candidates_of(const std::vector<BatchItem>& items,
                                           const std::vector<ItemResult>& results) {
  std::vector<PlacedRecording> candidates;
  const auto questions = question_stiffness(items, results);
  for (std::size_t i = 0; i < results.size(); ++i) {
    for (std::size_t k = 0; k < results[i].recordings.size(); ++k) {
      const Conditioned& r = results[i].recordings[k];
      candidates.push_back(
          {&items[i], &results[i], &r, nullptr, r.name, point_of(items[i], r.name)});
      candidates.back().failure = questions[i][k];
    }
    for (const Refused& r : results[i].refused) {
      candidates.push_back({&items[i], &results[i], nullptr, &r, r.name, items[i].point});
      candidates.back().failure = r.failure;
    }
  }
  return candidates;
}

// Points by name, in the order in which they first come; a member elsewhere is refused.
std::vector<Members> group_by_point(const BatchOptions& options,
                                    std::vector<PlacedRecording>& candidates) {
  std::vector<Members> points;
  std::map<std::string, std::size_t> index;
  for (PlacedRecording& c : candidates) {
    if (c.failure) continue;
    const auto [at, is_new] = index.emplace(c.point, points.size());
    if (is_new) points.emplace_back();
    Members& members = points[at->second];
    if (!members.empty() &&
        (members[0]->position_m - c.position_m).norm() > options.place_tolerance_m) {
      c.failure = Error(c.item->file.string(),
                        "lies elsewhere than " + shown(*members[0]) +
                            ", the first recording of point `" + c.point + "`",
                        "Give it a point of its own, or correct its position.");
      continue;
    }
    members.push_back(&c);
  }
  return points;
}

// The tips of known size, those that made most recordings first.
std::vector<UsedTip> tips_of(const std::vector<PlacedRecording>& candidates) {
  std::vector<UsedTip> out;
  for (const PlacedRecording& c : candidates)
    if (const UsedTip tip = tip_of(c);
        !c.failure && tip.radius_m > 0 && std::ranges::find(out, tip) == out.end())
      out.push_back(tip);
  std::ranges::stable_sort(out, std::greater<>{}, [&](const UsedTip& tip) {
    return std::ranges::count_if(
        candidates, [&](const PlacedRecording& c) { return !c.failure && tip_of(c) == tip; });
  });
  return out;
}

// The number of the tip that made a recording; 0 where it is not known.
std::int32_t tip_number(const std::vector<UsedTip>& tips, const PlacedRecording& c) {
  const auto at = std::ranges::find(tips, tip_of(c));
  return at == tips.end() ? 0 : static_cast<std::int32_t>(at - tips.begin());
}

// Recordings of each point, those of each tip by themselves: they have one curve.
std::vector<Members> by_tip(const std::vector<Members>& points, const std::vector<UsedTip>& tips) {
  std::vector<Members> out;
  for (const Members& members : points) {
    std::map<std::int32_t, Members> of_tip;
    for (PlacedRecording* m : members) of_tip[tip_number(tips, *m)].push_back(m);
    for (auto& [number, of_one] : of_tip) out.push_back(std::move(of_one));
  }
  return out;
}

void fill_rows(const std::vector<Pooled>& parts, Samples& samples) {
  Eigen::Index rows = 0;
  for (const Pooled& part : parts) rows += part.force_N.rows();
  samples.deflection.resize(rows, 3), samples.force.resize(rows, 3);
  samples.force_error.resize(rows), samples.torque = Points::Zero(rows, 3);
  const bool has_time =
      std::ranges::all_of(parts, [](const Pooled& p) { return p.time_s.size() > 0; });
  samples.time_s.resize(has_time ? rows : 0);
  Eigen::Index at = 0;
  for (const Pooled& from : parts) {
    const Eigen::Index n = from.force_N.rows();
    for (Eigen::Index i = 0; i < n; ++i) {
      samples.point.push_back(from.point);
      samples.experiment.push_back(from.experiment);
      samples.kind.push_back(from.kind);
      samples.probe_number.push_back(from.probe);
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

// Every recording an experiment of its own, in time; nothing where one has no clock.
std::optional<std::vector<std::vector<Pooled>>> experiments_in_time(
    const std::vector<Members>& points) {
  std::vector<std::vector<Pooled>> experiments;
  for (const Members& members : points) {
    experiments.emplace_back();
    for (PlacedRecording* m : members) {
      auto timed = in_time(*m);
      if (!timed) return std::nullopt;
      experiments.back().push_back(*std::move(timed));
    }
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

}  // namespace

std::size_t Assembled::failed() const {
  return std::ranges::count_if(outcomes,
                               [](const PlacedRecording& o) { return o.failure.has_value(); });
}

Assembled assemble(const std::vector<BatchItem>& items, const std::vector<ItemResult>& results,
                   const BatchOptions& options) {
  Assembled out;
  out.files = items.size();
  out.outcomes = candidates_of(items, results);
  std::vector<PlacedRecording>& candidates = out.outcomes;
  out.registration = place_on_body(options, candidates);
  const auto points = group_by_point(options, candidates);
  out.tips = tips_of(candidates);
  const auto alike = by_tip(points, out.tips);

  Samples& samples = out.samples;
  samples.point_position.resize(points.size(), 3);
  samples.point_normal.resize(points.size(), 3);
  std::vector<std::vector<Pooled>> experiments;
  for (const auto& members : points) experiments.push_back(pool(members));
  if (options.relaxation != RelaxationUse::none) out.relaxation = relaxation_of(alike);
  const bool relaxes =
      out.relaxation && out.relaxation->fit.relaxation.branches() > 0 &&
      (out.relaxation->doubts.empty() || options.relaxation == RelaxationUse::always);
  if (relaxes) {
    out.relaxation->is_applied = true;
    samples.relaxation = out.relaxation->fit.relaxation;
    if (auto timed = experiments_in_time(points))
      experiments = std::move(*timed);
    else
      out.notes.push_back(
          "some recordings have no clock: rows hold no time, and a fit takes their forces for "
          "those of slow motion");
  }
  std::vector<Pooled> parts;
  for (std::size_t p = 0; p < points.size(); ++p) {
    const PlacedRecording& first = *points[p][0];
    samples.point_position.row(p) = first.position_m;
    samples.point_normal.row(p) = first.inward;
    samples.point_name.push_back(first.point);
    if (!relaxes)  // else the rates are fitted
      std::ranges::copy(compare_rates(first.point, experiments[p]), std::back_inserter(out.notes));
    for (Pooled& pooled : experiments[p]) {
      const PlacedRecording& one = *pooled.member[0];
      pooled.point = static_cast<std::int32_t>(p);
      pooled.experiment = static_cast<std::int32_t>(parts.size());
      pooled.probe = tip_number(out.tips, one), pooled.kind = one.item->signal.kind;
      for (PlacedRecording* m : pooled.member) m->experiment = pooled.experiment;
      parts.push_back(std::move(pooled));
    }
  }
  if (const std::string note = break_note(candidates); !note.empty())
    out.notes.insert(out.notes.begin(), note);
  const auto copies = copy_notes(items, results);
  out.notes.insert(out.notes.begin(), copies.begin(), copies.end());
  if (out.relaxation) {
    const auto found = relaxation_notes(*out.relaxation);
    out.notes.insert(out.notes.begin(), found.begin(), found.end());
  }
  fill_rows(parts, samples);
  remove_void_columns(samples);
  if (items.empty() || !items.front().signal.is_pass)  // else their side force is friction
    if (const auto sideways = straighten_presses(samples); !sideways.empty())
      out.notes.push_back(sideways_note(samples, sideways));
  // Rows of every tip but the first are `other`, now that it does not matter that they press.
  for (std::size_t i = 0; i < samples.probe_number.size(); ++i)
    if (samples.probe_number[i] > 0) samples.kind[i] = ExperimentKind::other;
  samples.recordings = provenance(candidates);
  return out;
}

}  // namespace palpate::recordings
