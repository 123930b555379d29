#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "libfit/core/text.hpp"
#include "libfit/recordings/batch/steps.hpp"
#include "libfit/recordings/contact_point/approach.hpp"

namespace palpate::recordings {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kOtherCycle = 0.1;  // of the force: cycles of a good recording differ by less
constexpr double kTopOfPress = 0.1;  // of the travel, where cycles are compared

// Push over the deepest part of an approach that all of them reach, above where it begins.
double push_at_depth_N(const Signal& signal, const RowRange& approach, double from_m, double to_m) {
  const Eigen::VectorXd travel = signal.travel_m(), push = signal.push_N();
  const Eigen::Index free = std::max<Eigen::Index>(1, approach.rows() / 20);
  double sum = 0, n = 0;
  for (Eigen::Index i = approach.begin; i < approach.end; ++i)
    if (travel[i] >= from_m && travel[i] <= to_m) sum += push[i], n += 1;
  return n > 0 ? sum / n - push.segment(approach.begin, free).mean() : kNan;
}

// The press that the settings ask for, of those that go as deep, and a word on there being others.
RowRange chosen_cycle(const Signal& signal, const RowRange& main, const SignalSettings& settings,
                      const std::string& file, Conditioned& out) {
  const std::vector<RowRange> presses = presses_like(signal, main);
  const auto count = static_cast<int>(presses.size());
  if (settings.cycle > std::max(1, count))
    throw Error(file,
                fmt::format("holds {} as deep as its deepest, and cycle = {} is asked for",
                            counted(count, "press", "presses"), settings.cycle),
                "Say cycle = \"first\", \"last\" or a number that is there.");
  if (count < 2) return main;
  std::size_t taken = presses.size() - 1;
  if (settings.cycle > 0) taken = static_cast<std::size_t>(settings.cycle - 1);
  if (settings.cycle == kDeepestCycle)
    taken = static_cast<std::size_t>(std::ranges::find(presses, main.begin, &RowRange::begin) -
                                     presses.begin());
  if (taken >= presses.size()) return main;
  const Eigen::VectorXd travel = signal.travel_m();
  double reach_m = travel[main.end - 1];
  for (const RowRange& approach : presses) reach_m = std::min(reach_m, travel[approach.end - 1]);
  const double from_m = reach_m - kTopOfPress * (reach_m - travel[main.begin]),
               first_N = push_at_depth_N(signal, presses.front(), from_m, reach_m),
               last_N = push_at_depth_N(signal, presses.back(), from_m, reach_m),
               change = last_N / first_N - 1;
  std::string note = fmt::format("holds {} as deep; number {} is taken",
                                 counted(count, "press", "presses"), taken + 1);
  if (std::isfinite(change) && std::abs(change) > kOtherCycle) {
    note += fmt::format(", and the last is {} {} than the first", percent(std::abs(change), 0),
                        change < 0 ? "softer" : "stiffer");
    out.grade = std::max(out.grade, Grade::fair);
  }
  out.reasons.push_back(note);
  return presses[taken];
}

}  // namespace

void find_ranges(const SignalSettings& settings, const std::string& file, Signal& signal,
                 Conditioned& recording) {
  SignalRanges& out = signal.range;
  const bool is_press = settings.kind == ExperimentKind::press;
  const bool presses_once = is_press && settings.use == Use::approach;
  if (!is_press && (settings.use == Use::mean || settings.cycle != kDeepestCycle))
    throw Error(file, "`cycle` is for presses", "Leave it out, or say kind = \"press\".");
  std::vector<RowRange>& loadings = out.first_loadings;
  if (presses_once && settings.cycle == kDeepestCycle) loadings = first_loadings(signal);
  RowRange& approach = out.approach;
  approach = loadings.empty() ? main_approach(signal) : loadings.front();
  if (is_press && settings.use != Use::mean && loadings.empty() && approach.rows() >= 2)
    approach = chosen_cycle(signal, approach, settings, file, recording);
  for (const RowRange& range : loadings.empty() ? std::vector{approach} : loadings)
    if (presses_once && !out.break_in) out.break_in = break_in_row(signal, range);
  if (out.break_in) {  // beyond it there is no curve of the body
    const Eigen::Index end = *out.break_in + 1;
    std::erase_if(loadings, [&](const RowRange& range) { return range.begin >= end; });
    for (RowRange& range : loadings) range.end = std::min(range.end, end);
    approach.end = std::min(approach.end, end);
  }
  out.loading =
      approach.rows() >= 2 && is_press && !out.break_in ? loading_part(signal, approach) : approach;
  if (out.loading.rows() < 2)
    throw Error(place(file, signal, 0), "the tip never goes in",
                "Check the normal, or turn the depth around: depth = \"-NAME\".");
}

}  // namespace palpate::recordings
