// The statement of error as sentences and a table.

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "libfit/core/stated_error.hpp"
#include "libfit/core/statistics.hpp"
#include "libfit/core/text.hpp"
#include "libfit/validation/statement.hpp"

namespace palpate::validation {
namespace {

constexpr std::size_t kColumns = 80;

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
     "Most of it is what the law of the curves cannot say: leave family of [fit] to \"auto\", and "
     "give [experiments] more drag_depths and drag_directions."},
    {"friction_law",
     "Most of it is felt while sliding: drag at every point (drag_points = \"all\" in "
     "[experiments]), at more drag_depths and drag_directions."},
};

// The unit that forces of a body are told in.
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

Unit torque_unit(const std::vector<NamedTorque>& errors) {
  double largest_Nm = 0;
  for (const NamedTorque& e : errors) largest_Nm = std::max({largest_Nm, e.typical_Nm, e.max_Nm});
  return largest_Nm < 1e-4 ? Unit{"uNm", 1e6, 2} : Unit{"Nmm", 1e3, 2};
}

// A line of the table: what it is of, then its share of the force (torque) and its size, twice or
// thrice.
std::string line(std::string_view name, std::initializer_list<std::pair<double, double>> figures,
                 const Unit& unit) {
  std::string text = fmt::format("  {:<21}", name);
  for (const auto& [share, size] : figures)
    text += fmt::format("{:>8} {:>{}.{}f} {}", stated_percent(share), unit.factor * size,
                        8 - unit.name.size(), unit.decimals, unit.name);
  return text + "\n";
}

std::string columns(std::string_view title) {
  return fmt::format("{:<23}{:>18}{:>18}{:>18}\n", title, "median", "p95", "max");
}

std::string lines(std::string_view title, const std::vector<NamedError>& errors, const Unit& unit) {
  std::string text;
  if (!errors.empty()) text = fmt::format("{}\n", title);
  for (const NamedError& e : errors)
    text += line(e.name, {{e.median_rel, e.median_N}, {e.p95_rel, e.p95_N}}, unit);
  return text;
}

std::string lines(std::string_view title, const std::vector<NamedTorque>& errors) {
  std::string text;
  if (!errors.empty()) text = columns(title);
  for (const NamedTorque& e : errors)
    text +=
        line(e.name, {{e.median_rel, e.median_Nm}, {e.p95_rel, e.p95_Nm}, {e.max_rel, e.max_Nm}},
             torque_unit(errors));
  return text;
}

std::string lines_with_largest(std::string_view title, const std::vector<NamedError>& errors,
                               const Unit& unit) {
  std::string text;
  if (!errors.empty()) text = columns(title);
  for (const NamedError& e : errors)
    text += line(e.name, {{e.median_rel, e.median_N}, {e.p95_rel, e.p95_N}, {e.max_rel, e.max_N}},
                 unit);
  return text;
}

// Sentences in lines that a terminal holds.
std::string wrapped(std::string_view text) {
  std::string out;
  while (text.size() > kColumns) {
    const std::size_t end = text.rfind(' ', kColumns);
    out += std::string(text.substr(0, end)) + "\n";
    text.remove_prefix(end + 1);
  }
  return out + std::string(text) + "\n";
}

// The group of paths with the largest p95, and the cause that counts most; none: null.
const NamedError* worst(const std::vector<NamedError>& errors) {
  const NamedError* found = nullptr;
  for (const NamedError& error : errors)
    if (!std::isnan(error.p95_rel) && (found == nullptr || error.p95_rel > found->p95_rel))
      found = &error;
  return found;
}

std::string tables(const Statement& s) {
  const Unit unit = force_unit(s);
  std::string words =
      columns("") +
      line("all", {{s.median_rel, s.median_N}, {s.p95_rel, s.p95_N}, {s.max_rel, s.max_N}}, unit);
  words += lines("by path", s.by_path, unit) + lines("by cause", s.causes, unit) +
           lines("of what is simpler", s.baselines, unit);
  words += lines("torque error", s.torque);
  words += lines_with_largest("two tools on the body", s.two_tools, unit);
  if (s.two_tools_tick_ns > 0)
    words += fmt::format("a tick of both: {:.0f} ns on this machine\n", s.two_tools_tick_ns);
  words += lines_with_largest("the tool, as balls", s.tool, unit) +
           lines("torque error of it", s.tool_torque);
  if (s.tool_tick_ns > 0)
    words += fmt::format("a tick of it: {:.0f} ns on this machine\n", s.tool_tick_ns);
  return words;
}

std::string of_reference(const Statement& s) {
  std::string words;
  if (!std::isnan(s.reference_p95_rel))
    words =
        fmt::format("the reference's own estimated error: p95 {}\n", percent(s.reference_p95_rel));
  words += fmt::format("rows that the reference could not solve: {}\n", s.reference_failures);
  if (s.reference_p95_rel > kToldReference * s.p95_rel)
    words += fmt::format(
        "this compares noise in part: at {} of rows the error is within the\n"
        "reference's own; force_tolerance of [validate] asks for a finer reference\n",
        percent(s.within_reference, 0));
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

std::string verdict(const Statement& s) {
  if (s.rows == 0) return "No verdict: no row could be compared.";
  if (std::isnan(s.p95_rel)) return fmt::format("No verdict: no row above {}.", newtons(s.floor_N));
  const bool can_be_felt = !std::isnan(s.within_jnd);
  const auto grade = [&] {
    if (s.p95_rel > kPoor) return "Poor";
    return s.p95_rel > kForceJnd ? "Fair" : "Good";
  };
  std::string words = fmt::format("{}: 19 of 20 rows are off by {} of their force at most", grade(),
                                  percent(s.p95_rel));
  if (!can_be_felt)
    return words + fmt::format(". No force here reaches {}, the least that a person feels.",
                               newtons(kForceFloor_N));
  return words + fmt::format(", {} than the {} that a person notices.",
                             s.p95_rel > kForceJnd ? "more" : "no more", percent(kForceJnd, 0));
}

std::vector<std::string> advice(const Statement& s) {
  std::vector<std::string> out;
  if (!(s.p95_rel > kPoor)) return out;
  if (s.reference_p95_rel > kToldReference * s.p95_rel)
    out.push_back(
        fmt::format("The reference itself is uncertain by {}: ask for a finer one with "
                    "force_tolerance = {} in [validate].",
                    percent(s.reference_p95_rel), number(s.reference_p95_rel / 3, 1)));
  if (const NamedError* path = worst(s.by_path); path && path->p95_rel > s.p95_rel)
    out.push_back(fmt::format("It is worst on paths of the kind {}, {}.", path->name,
                              percent(path->p95_rel)));
  const NamedError* cause = worst(s.causes);
  for (const Remedy& remedy : kRemedies)
    if (cause && cause->name == remedy.cause) out.emplace_back(remedy.sentence);
  if (!cause)
    out.emplace_back(
        "What it is made of is not known: set causes = true in [validate] and run without --quick "
        "to see which part to improve; more test points in [experiments] are the first thing to "
        "try.");
  return out;
}

std::string in_words(const Statement& s) {
  std::string words =
      fmt::format("force error at {} held-out contact points, {} rows\n", s.probes, s.rows);
  if (s.rows > 0) {
    const std::string table = tables(s), floor = newtons(s.floor_N);
    const bool has_gap = table.find(" - ") != std::string::npos;
    words +=
        wrapped(fmt::format("shares of the force are of the {} above {}{}",
                            counted(static_cast<std::int64_t>(s.rows_above_floor), "row", "rows"),
                            floor, has_gap ? fmt::format(" (-: no row above {})", floor) : ""));
    words += table;
    words += std::isnan(s.within_jnd)
                 ? fmt::format("no force reaches {}, the least that a person feels\n",
                               newtons(kForceFloor_N))
                 : fmt::format(
                       "within the force just noticeable to a person, max(0.04 N, 7 %): {} of "
                       "rows\n",
                       percent(s.within_jnd, 0));
  }
  words += of_reference(s) + of_shape(s.shape);
  if (!std::isnan(s.tick_ns))
    words +=
        fmt::format("{:.0f} ns per tick on this machine, {} bytes\n", s.tick_ns, s.asset_bytes);
  words += wrapped(verdict(s));
  for (const std::string& sentence : advice(s)) words += wrapped(sentence);
  words.pop_back();
  return words;
}

}  // namespace palpate::validation
