// The statement of error as sentences and a table.

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "libfit/core/perception.hpp"
#include "libfit/core/stated_error.hpp"
#include "libfit/core/statistics.hpp"
#include "libfit/core/text.hpp"
#include "libfit/validation/statement.hpp"

namespace palpate::validation {
namespace {

struct Remedy {
  std::string_view cause, sentence;
};
constexpr Remedy kRemedies[] = {
    {"interpolation",
     "Most of it lies between test points: take more of them (test_points or, where they place "
     "themselves, a smaller tolerance and a larger budget in [experiments])."},
    {"curve_fit",
     "Most of it is left by the curves: give [fit] a smaller tolerance, and [experiments] more "
     "press_steps and drag_steps."},
    {"curve_family",
     "Most of it is what the law of the curves cannot say: leave family of [fit] at \"rings\", and "
     "give [experiments] more drag_depths and drag_directions."},
    {"friction_law",
     "Most of it is felt while sliding: drag at more drag_depths and in more drag_directions."},
};

// The unit in which forces of a body are written.
struct Unit {
  std::string_view name;
  double factor;
  int decimals;
};
constexpr Unit kNewton{"N", 1, 4};

Unit force_unit(const Statement& s) {
  if (s.floor_N > 0 && s.floor_N < 4e-6) return {"uN", 1e6, 3};
  return s.floor_N > 0 && s.floor_N < 4e-3 ? Unit{"mN", 1e3, 3} : kNewton;
}

Unit torque_unit(const std::vector<StatedError>& lines) {
  double largest_Nm = 0;
  for (const StatedError& line : lines)
    largest_Nm = std::max({largest_Nm, line.handle.typical, line.handle.max});
  return largest_Nm < 1e-4 ? Unit{"uNm", 1e6, 2} : Unit{"Nmm", 1e3, 2};
}

// A line of a table: what it is of, the median and p95 of its share of the force (torque), p95 in
// the unit.
std::string line(std::string_view name, const ErrorFigures& e, const Unit& unit) {
  return fmt::format("  {:<21}{:>8}{:>8} {:>{}.{}f} {}", name, stated_percent(e.median_rel),
                     stated_percent(e.p95_rel), unit.factor * e.p95, 9 - unit.name.size(),
                     unit.decimals, unit.name);
}

// The same of a force's size and direction.
std::string line(const Spread& magnitude, const Spread& direction_deg) {
  const auto degrees = [](double angle_deg) {
    return std::isnan(angle_deg) ? "-" : fmt::format("{:.1f}", angle_deg);
  };
  return fmt::format("{:>8}{:>8}{:>7}{:>7}\n", stated_percent(magnitude.median),
                     stated_percent(magnitude.p95), degrees(direction_deg.median),
                     degrees(direction_deg.p95));
}

// A section as a table of forces, then one of torques where they were compared.
std::string table(const StatementSection& section, const Unit& unit) {
  if (section.lines.empty()) return {};
  std::string text = fmt::format("{:<23}{:>8}{:>8}{:>10}{:>9}{:>8}{:>7}{:>7}\n", section.title,
                                 "median", "p95", "p95", "median", "p95", "median", "p95");
  for (const StatedError& of : section.lines)
    text += line(of.name, of.force, unit) + line(of.magnitude, of.direction_deg);
  std::string torques;
  for (const StatedError& of : section.lines)
    if (!std::isnan(of.handle.median))
      torques += line(of.name, of.handle, torque_unit(section.lines)) + "\n";
  if (!torques.empty()) text += section.title + ", torque at the handle\n" + torques;
  for (const StatedError& of : section.lines)
    if (!std::isnan(of.tick_ns))
      text += fmt::format("a tick of {}: {:.0f} ns on this machine\n", of.name, of.tick_ns);
  return text;
}

// The line with the largest p95; none: null.
const StatedError* worst(const std::vector<StatedError>& lines) {
  const StatedError* found = nullptr;
  for (const StatedError& line : lines)
    if (!std::isnan(line.force.p95_rel) &&
        (found == nullptr || line.force.p95_rel > found->force.p95_rel))
      found = &line;
  return found;
}

std::string tables(const Statement& s) {
  const Unit unit = force_unit(s);
  StatedError all = s.all;
  all.tick_ns = kNoNumber;  // written at the end
  if (all.rows == 0 && s.sections.empty()) return {};
  std::string words =
      fmt::format("{:<23}{:>26}{:>17}{:>14}\n", "", "error of the force", "of its size", "degrees");
  if (all.rows > 0)
    words += table({"all", s.is_recorded ? "all held out" : "all paths", {all}}, unit);
  for (const StatementSection& section : s.sections) words += table(section, unit);
  return words;
}

std::string of_reference(const Statement& s) {
  std::string words;
  if (!std::isnan(s.reference_p95_rel))
    words =
        fmt::format("the {} own estimated error: p95 {}\n",
                    s.is_recorded ? "recordings'" : "reference's", percent(s.reference_p95_rel));
  if (s.is_recorded)
    return words + fmt::format("held-out rows that import rejected: {}\n", s.reference_failures);
  words += fmt::format("rows that the reference could not solve: {}\n", s.reference_failures);
  if (s.reference_p95_rel > kMentionedReference * s.all.force.p95_rel)
    words += fmt::format(
        "this compares noise in part: at {} of rows the error is within the\n"
        "reference's own; force_tolerance of [validate] asks for a finer reference\n",
        percent(s.within_reference, 0));
  return words;
}

// A hand's thresholds, and the rows within them.
std::string of_hand(const Statement& s) {
  const Perception& known = perception();
  if (std::isnan(s.all.unnoticed))
    return fmt::format("no force reaches {}, the least that a person feels\n",
                       newtons(known.force_floor_N));
  std::string words = wrapped(fmt::format(
      "of rows above {} a person would not notice the error in {}: less than {} of the force, "
      "{} of one that slides, and {:.0f} degrees",
      newtons(known.force_floor_N), percent(s.all.unnoticed, 0), percent(known.force_at_rest, 0),
      percent(known.force_in_motion, 0), known.direction_deg));
  if (!std::isnan(s.all.handle.p95_rel))
    words += wrapped(fmt::format(
        "torque at a handle {:.0f} mm away: {} (p95) of {:.3g} N mm (median); a person notices {}",
        1e3 * s.handle_m, percent(s.all.handle.p95_rel), 1e3 * s.all.handle.typical,
        percent(known.torque)));
  return words;
}

std::string of_shape(const ShapeError& shape) {
  if (shape.rows == 0) return {};
  const ShapeErrorFigures& near = shape.near;
  if (std::isnan(near.median_m))
    return fmt::format(
        "the surface is shown within {} of the depth over the whole body (p95); no\n"
        "vertex of it is near the tool\n",
        percent(shape.all.p95_rel));
  return fmt::format(
      "the surface is shown within {:.2f} mm near the tool, {} of the depth (median;\n"
      "p95 {:.2f} mm, {}), and within {} over the whole body (p95)\n",
      1e3 * near.median_m, percent(near.median_rel), 1e3 * near.p95_m, percent(near.p95_rel),
      percent(shape.all.p95_rel));
}

}  // namespace

std::string wrapped(std::string_view text) {
  std::string out;
  while (text.size() > 80) {
    const std::size_t end = text.rfind(' ', 80);
    out += std::string(text.substr(0, end)) + "\n";
    text.remove_prefix(end + 1);
  }
  return out + std::string(text) + "\n";
}

std::string verdict(const Statement& s) {
  const double p95_rel = s.all.force.p95_rel;
  if (s.all.rows == 0)
    return s.is_recorded ? "No verdict: no recording within the fitted points was held out."
                         : "No verdict: no row could be compared.";
  if (std::isnan(p95_rel)) return fmt::format("No verdict: no row above {}.", newtons(s.floor_N));
  // Over what a person notices at rest; kPoor of the force is poor, and as much more of direction.
  const Perception& known = perception();
  const auto grade = [&](double magnitude, double direction_deg) {
    const double over =
        std::max(magnitude / known.force_at_rest, direction_deg / known.direction_deg);
    return over > kPoor / known.force_at_rest ? "poor" : over > 1 ? "fair" : "good";
  };
  const Spread &size = s.all.magnitude, &turned = s.all.direction_deg;
  const std::vector<StatedError>& changing = s.lines_of("where_it_changes");
  const Spread there = changing.empty() ? Spread() : changing[0].magnitude;
  const auto ends = [](double end, double p95) { return std::isnan(end) ? p95 : end; };
  const std::string best = grade(ends(size.p95_low, size.p95), ends(turned.p95_low, turned.p95)),
                    worst = grade(std::fmax(ends(size.p95_high, size.p95), there.p95),
                                  ends(turned.p95_high, turned.p95));
  std::string words = worst;
  if (best != worst) words += worst == "poor" && best == "good" ? " to " + best : " or " + best;
  words[0] = static_cast<char>(words[0] - 'a' + 'A');
  words += fmt::format(": 19 of 20 forces are within {} of the {}", percent(p95_rel),
                       s.is_recorded ? "recorded" : "simulated");
  if (!std::isnan(s.p95_rel_low))
    words += s.p95_rel_high > 10 ? " (too few places to tell)"  // ten times the force: no bound
                                 : fmt::format(" ({} to {}, as few places were tried)",
                                               percent(s.p95_rel_low), percent(s.p95_rel_high));
  words += fmt::format(": {} in size", percent(size.p95));
  if (!std::isnan(turned.p95)) words += fmt::format(", {:.2g} degrees in direction", turned.p95);
  if (!std::isnan(there.p95))
    words += fmt::format("; {} in size where stiffness changes most", percent(there.p95));
  words += std::isnan(s.all.unnoticed)
               ? fmt::format(
                     ". No force here reaches {}, the least that a person feels: are length "
                     "unit and moduli right?",
                     newtons(known.force_floor_N))
               : fmt::format(". A person would notice the error in {} of the forces above {}.",
                             percent(1 - s.all.unnoticed, 0), newtons(known.force_floor_N));
  std::string others;
  const auto add = [&](const std::string& what) {
    others += (others.empty() ? " Also off, at most in 19 of 20: " : ", ") + what;
  };
  if (s.slip_onset.paths > 0)
    add(fmt::format("the onset of slip by {:.2g} mm and {}", 1e3 * s.slip_onset.place_m.p95,
                    newtons(s.slip_onset.force_N.p95)));
  if (!std::isnan(s.all.handle.p95_rel))
    add(fmt::format("torque at a handle by {}", percent(s.all.handle.p95_rel)));
  if (s.shape.rows > 0 && !std::isnan(s.shape.near.p95_m))
    add(fmt::format("the surface near the tool by {:.2g} mm", 1e3 * s.shape.near.p95_m));
  if (!others.empty()) words += others + ".";
  if (s.interval)
    words += fmt::format(
        " A real body's forces may be {:.0f} % lower to {:.0f} % higher, by how well its material "
        "{} known.",
        -100 * s.interval->low_rel, 100 * s.interval->high_rel,
        std::isnan(s.interval->held) ? "(not its support) is" : "and support are");
  return words;
}

namespace {

// Baselines beside recordings show where the error comes from.
std::vector<std::string> recorded_advice(const Statement& s) {
  std::vector<std::string> out;
  const double p95_rel = s.all.force.p95_rel;
  const StatedError* fitted = worst(s.lines_of("fitted"));
  const bool is_scan = !s.lines_of("by_motion").empty();  // its surface was found with its curves
  if (fitted && fitted->force.p95_rel > 0.5 * p95_rel)
    out.push_back(fmt::format(
        "The curves miss the recordings that they were fitted to by {} (p95): see the worst points "
        "of `fit`, and the grades and notes of `import`.",
        percent(fitted->force.p95_rel)));
  for (const StatedError& simpler : s.lines_of("baselines"))
    if (simpler.force.p95_rel < 0.9 * p95_rel)
      out.push_back(fmt::format(
          "{} is off by less, {}: {}.", simpler.name, percent(simpler.force.p95_rel),
          is_scan ? "scan with measured poses, a force sensor and several depths at each place"
                  : "the surface or its normals may not be where the tool touched"));
  if (out.empty())
    out.emplace_back(is_scan ? "Most of it lies between the passes: record more of them."
                             : "Most of it lies between the points: press more of them.");
  return out;
}

}  // namespace

std::optional<std::string> advice_on_held_part(double held_share) {
  if (!(held_share > 0.05)) return std::nullopt;
  return fmt::format(
      "{} of a press's force comes from where the body is held: that much is lost where only the "
      "farther half of it is. Hold what anatomy holds (fixed), or put the body on a [[bed]].",
      percent(held_share, 0));
}

std::vector<std::string> advice(const Statement& s) {
  std::vector<std::string> out;
  if (const auto held = advice_on_held_part(s.held_share)) out.push_back(*held);
  const double p95_rel = s.all.force.p95_rel;
  if (!(p95_rel > kPoor)) return out;
  if (s.is_recorded) return recorded_advice(s);
  if (s.reference_p95_rel > kMentionedReference * s.all.force.p95_rel)
    out.push_back(
        fmt::format("The reference itself is uncertain by {}: ask for a finer one with "
                    "force_tolerance = {} in [validate].",
                    percent(s.reference_p95_rel), number(s.reference_p95_rel / 3, 1)));
  if (const StatedError* path = worst(s.lines_of("by_path")); path && path->force.p95_rel > p95_rel)
    out.push_back(fmt::format("It is worst on paths of the kind {}, {}.", path->name,
                              percent(path->force.p95_rel)));
  const StatedError* cause = worst(s.lines_of("causes"));
  for (const Remedy& remedy : kRemedies)
    if (cause && cause->name == remedy.cause) out.emplace_back(remedy.sentence);
  if (!cause)
    out.emplace_back(
        "More test points in [experiments] are the first thing to try; causes = true in "
        "[validate], without --quick, says which part to improve.");
  return out;
}

std::string in_words(const Statement& s) {
  std::string words = fmt::format(
      "force error at {} held-out {}, {} rows{}\n", s.probes,
      s.is_recorded ? "recorded points" : "contact points", s.all.rows,
      s.beyond > 0 ? fmt::format("; {} more lie beyond the fitted ones", s.beyond) : "");
  if (s.all.rows > 0 || s.is_recorded) {
    const std::string table = tables(s);
    const std::string floor = newtons(s.floor_N);
    const bool has_gap = table.find(" - ") != std::string::npos;
    words +=
        wrapped(fmt::format("shares of the force are of the {} above {}{}",
                            counted(static_cast<std::int64_t>(s.rows_above_floor), "row", "rows"),
                            floor, has_gap ? fmt::format(" (-: no row above {})", floor) : ""));
    words += table;
    if (s.all.rows > 0) words += of_hand(s);
  }
  words += of_reference(s) + of_shape(s.shape);
  if (!std::isnan(s.all.tick_ns))
    words +=
        fmt::format("{:.0f} ns per tick on this machine, {} bytes\n", s.all.tick_ns, s.asset_bytes);
  if (s.interval) words += wrapped(in_words(*s.interval));
  words += wrapped(verdict(s));
  for (const std::string& sentence : advice(s)) words += wrapped(sentence);
  words.pop_back();
  return words;
}

}  // namespace palpate::validation
