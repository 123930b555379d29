#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>

#include "libfit/core/perception.hpp"
#include "libfit/core/text.hpp"
#include "libfit/recordings/placing/assemble.hpp"

namespace palpate::recordings {
namespace {

constexpr double kMinHeld = 0.1;      // share of the time in contact, of a hold
constexpr std::size_t kMaxUsed = 12;  // recordings of one search

bool is_press_in_time(const PlacedRecording& c, Grade worst) {
  return !c.failure && c.item->signal.kind == ExperimentKind::press &&
         c.recording->history.rows() >= 20 && c.recording->grade <= worst;
}

std::vector<TimedPress> histories_of(const Members& members) {
  std::vector<TimedPress> out;
  for (const PlacedRecording* m : members) out.push_back(m->recording->history);
  return out;
}

std::string between(double low, double high, const char* unit) {
  if (!std::isfinite(high)) return fmt::format("above {}{}", number(low), unit);
  return fmt::format("{} to {}{}", number(low), number(high), unit);
}

std::string branch_in_words(const RelaxationFit& fit, Eigen::Index k) {
  return fmt::format(
      "relaxation, branch {} of {}: {} ({}) of the stiffness of slow motion, time {} s ({})", k + 1,
      fit.relaxation.branches(), number(fit.relaxation.share[k]),
      between(fit.share_low[k], fit.share_high[k], ""), number(fit.relaxation.time_s[k]),
      fit.is_slower[k] ? "slower than the recordings: it may be longer, and slow motion softer"
                       : between(fit.time_low_s[k], fit.time_high_s[k], " s"));
}

// Points whose stiffness at once is not the body's by so many errors and such a share, each with
// its own.
std::vector<std::string> points_apart(const BodyRelaxation& found, double errors, double share) {
  const Eigen::VectorXd at_once = Eigen::VectorXd::Constant(1, found.fit.shortest_s);
  const auto band = found.fit.band(at_once);
  std::vector<std::string> apart;
  for (const BodyRelaxation::PointSeries& point : found.points) {
    const auto own = point.fit.band(at_once);
    const double error = std::hypot(own.high[0] - own.middle[0], band.high[0] - band.middle[0]) / 2;
    if (std::abs(own.middle[0] - band.middle[0]) > std::max(errors * error, share * band.middle[0]))
      apart.push_back(fmt::format("{} ({})", point.name, number(own.middle[0])));
  }
  return apart;
}

// A series that the recordings do not end tells no slow motion, and one that points do not share
// makes each of them worse than the mean of its repeats.
std::vector<std::string> doubts_of(const BodyRelaxation& found) {
  std::vector<std::string> doubts;
  if (std::ranges::any_of(found.fit.is_slower, [](char is_slower) { return is_slower != 0; }))
    doubts.emplace_back("a branch is slower than the recordings");
  if (!points_apart(found, 3, perception().force_at_rest).empty())
    doubts.emplace_back("points do not relax alike");
  return doubts;
}

// Presses of each point that show how the body changes in time, those that show most first.
std::vector<Members> presses_in_time(const std::vector<Members>& points, bool& has_holds) {
  // Poor recordings only where there is nothing better.
  Grade worst = Grade::fair;
  const auto usable = [&](const PlacedRecording* m) { return is_press_in_time(*m, worst); };
  if (std::ranges::none_of(
          points, [&](const Members& members) { return std::ranges::any_of(members, usable); }))
    worst = Grade::poor;
  struct Usable {
    double information = 0;
    Members member;
    bool has_hold = false, has_rates = false;
  };
  std::vector<Usable> usable_points;
  for (const Members& members : points) {
    Usable point;
    double slowest = kInfinity, fastest = 0, held = 0;
    for (PlacedRecording* m : members) {
      if (!usable(m)) continue;
      point.member.push_back(m);
      const TimedPress& history = m->recording->history;
      held = std::max(held, held_share(history));
      const double speed = m->recording->speed_m_s;
      if (speed > 0) slowest = std::min(slowest, speed), fastest = std::max(fastest, speed);
    }
    point.has_hold = held >= kMinHeld;
    point.has_rates = fastest > kSameRate * slowest;
    if (!point.has_hold && !point.has_rates) continue;
    // The slowest and the fastest first, then in order.
    if (point.has_rates)
      std::ranges::stable_sort(point.member, {}, [&](const PlacedRecording* m) {
        const double v = m->recording->speed_m_s;
        return v >= fastest || v <= slowest ? 0 : 1;
      });
    point.information = held + (point.has_rates ? std::log10(fastest / slowest) : 0);
    usable_points.push_back(std::move(point));
  }
  std::ranges::stable_sort(usable_points, std::greater<>{}, &Usable::information);
  std::vector<Members> out;
  std::size_t used = 0;
  for (Usable& point : usable_points) {
    if (used >= kMaxUsed) break;
    point.member.resize(std::min(point.member.size(), kMaxUsed - used));
    used += point.member.size();
    has_holds |= point.has_hold;
    out.push_back(std::move(point.member));
  }
  return out;
}

}  // namespace

std::optional<BodyRelaxation> relaxation_of(const std::vector<Members>& all) {
  BodyRelaxation out;
  const std::vector<Members> points = presses_in_time(all, out.has_holds);
  if (points.empty()) return std::nullopt;
  std::vector<std::vector<TimedPress>> presses;
  for (const Members& members : points) presses.push_back(histories_of(members));
  out.fit = fit_relaxation(presses);
  std::vector<std::size_t> held;
  for (std::size_t p = 0; p < points.size(); ++p) {
    bool has_hold = false;
    for (const PlacedRecording* m : points[p]) {
      has_hold |= held_share(m->recording->history) >= kMinHeld;
      out.recordings.push_back({shown(*m), m->point});
    }
    if (has_hold) held.push_back(p);
  }
  const auto branches = static_cast<int>(out.fit.relaxation.branches());
  if (branches > 0 && held.size() > 1)
    for (const std::size_t p : held)
      out.points.push_back({points[p][0]->point, fit_relaxation({presses[p]}, branches)});
  out.doubts = doubts_of(out);
  return out;
}

std::vector<std::string> relaxation_notes(const BodyRelaxation& found) {
  const RelaxationFit& fit = found.fit;
  std::vector<std::string> notes;
  const std::string by =
      counted(static_cast<std::int64_t>(found.recordings.size()), "recording", "recordings") +
      (found.has_holds ? " with holds" : " at several rates");
  const Eigen::Index branches = fit.relaxation.branches();
  if (branches == 0) {
    notes.push_back(fmt::format(
        "relaxation: none is seen in {}: a branch between {} s and {} s predicts held-out "
        "stretches of time no better",
        by, number(fit.shortest_s), number(fit.longest_s)));
    return notes;
  }
  const auto band = fit.band(Eigen::VectorXd::Constant(1, fit.shortest_s));
  notes.push_back(fmt::format(
      "relaxation, by {}: {} s after a step the body is {} times ({}) as stiff as in slow motion",
      by, number(fit.shortest_s), number(band.middle[0]), between(band.low[0], band.high[0], "")));
  for (Eigen::Index k = 0; k < branches; ++k) notes.push_back(branch_in_words(fit, k));
  if (const auto other = points_apart(found, 2, 0); !other.empty())
    notes.push_back("relaxation: not alike over the body; other stiffness at once: " +
                    listed(other));
  if (!found.is_applied)
    notes.push_back("relaxation is proposed, not applied: " + listed(found.doubts, "; ") +
                    "; relaxation = \"apply\" in the manifest takes it all the same");
  return notes;
}

std::optional<Pooled> in_time(PlacedRecording& c) {
  const Conditioned& r = *c.recording;
  if (r.history.rows() == 0) {  // a drag or path
    bool rises = r.time_s.size() > 0 && r.time_s[0] >= 0;
    for (Eigen::Index i = 1; i < r.time_s.size(); ++i) rises &= r.time_s[i] > r.time_s[i - 1];
    return rises ? std::optional(on_body(c)) : std::nullopt;
  }
  const TimedPress& p = r.history;
  Eigen::Index deepest = 0;
  p.depth_m.maxCoeff(&deepest);
  Eigen::Index first = deepest, end = deepest;
  while (first > 0 && p.depth_m[first - 1] > 0) --first;
  while (end < p.rows() && p.depth_m[end] > 0) ++end;
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = first; i < end; ++i)
    if (p.readings[i] > 0) rows.push_back(i);
  Pooled out{{}, {&c}, r.speed_m_s};
  const Eigen::Index n = rows.size();
  Points deflection = Points::Zero(n, 3), force = Points::Zero(n, 3);
  if (p.deflection_m.rows() > 0) {
    deflection = p.deflection_m(rows, Eigen::all), force = p.force_N(rows, Eigen::all);
  } else {
    deflection.col(0) = p.depth_m(rows), force.col(0) = p.push_N(rows);
  }
  out.deflection_m = deflection * c.to_body.transpose();
  out.force_N = force * c.to_body.transpose();
  out.time_s = p.time_s(rows).array() - touch_time_s(p.time_s, p.depth_m, first);
  out.error_N = r.noise_N / p.readings(rows).array().sqrt();
  const double pulled_N = -3 * r.noise_N;  // the tip sticks: no contact law has that
  for (const Eigen::Index i : rows)
    out.status.push_back(p.push_N[i] < pulled_N ? RowStatus::rejected : RowStatus::good);
  return out;
}

}  // namespace palpate::recordings
