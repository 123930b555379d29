#include "libfit/recordings/placing/place.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "libfit/core/statistics.hpp"
#include "libfit/core/text.hpp"
#include "libfit/recordings/contact_point/contact_point.hpp"
#include "libfit/recordings/signal/signal.hpp"

namespace palpate::recordings {
namespace {

constexpr int kParts = 3;  // of the rows, over which the steepest slope is taken

// "12 % larger"
std::string change(double share) {
  return number(std::abs(100 * share)) + (share < 0 ? " % smaller" : " % larger");
}

double steepest_N_m(const Eigen::VectorXd& depth_m, const Eigen::VectorXd& push_N) {
  const Eigen::Index part = depth_m.size() / kParts;
  double steepest = 0;
  for (Eigen::Index first = 0; part > 1 && first + part <= depth_m.size(); first += part)
    steepest = std::max(steepest,
                        fit_line(depth_m.segment(first, part), push_N.segment(first, part)).slope);
  return steepest;
}

}  // namespace

std::optional<CantileverEffect> cantilever_effect(const BatchItem& item, const Conditioned& r) {
  if (!r.source.cantilever || !(r.source.cantilever->stiffness_N_m > 0)) return std::nullopt;
  const importers::Cantilever& c = *r.source.cantilever;
  std::vector<Eigen::Index> good;
  for (std::size_t i = 0; i < r.status.size(); ++i)
    if (r.status[i] == RowStatus::good) good.push_back(static_cast<Eigen::Index>(i));
  if (good.empty()) return std::nullopt;
  const Eigen::VectorXd depth_m = r.deflection_m(good, Eigen::all).rowwise().norm(),
                        push_N = r.force_N(good, Eigen::all).rowwise().norm();
  Eigen::Index deepest = 0;
  depth_m.maxCoeff(&deepest);
  const double exponent = item.signal.radius_m > 0 || item.signal.tip != Tip::sphere
                              ? exponent_of(item.signal.tip)
                              : 2;  // as apparent_modulus_Pa counts
  const double bent = exponent * push_N[deepest] / c.stiffness_N_m / depth_m[deepest];
  if (!r.source.is_force_from_signal) return CantileverEffect{-bent, 0, 0};
  CantileverEffect effect{1, 1 + bent, 0};
  if (const double slope_N_m = steepest_N_m(depth_m, push_N); slope_N_m > 0)
    effect.max_sensitivity_m = c.sensitivity_m * (1 + c.stiffness_N_m / slope_N_m);
  return effect;
}

std::vector<std::string> cantilever_notes(const std::vector<BatchItem>& items,
                                          const std::vector<Candidate>& candidates) {
  std::vector<double> stiffness, sensitivity, max_m, open;
  const importers::Cantilever* cantilever = nullptr;
  bool is_stated = false;
  for (const Candidate& candidate : candidates) {
    if (candidate.failure) continue;
    const auto effect = cantilever_effect(items[candidate.item], *candidate.recording);
    if (!effect) continue;
    is_stated |= items[candidate.item].read.cantilever.has_value();
    cantilever = &*candidate.recording->source.cantilever;
    stiffness.push_back(effect->stiffness);
    sensitivity.push_back(effect->sensitivity);
    max_m.push_back(effect->max_sensitivity_m);
    open.push_back(std::hypot(effect->stiffness * cantilever->stiffness_deviation,
                              effect->sensitivity * cantilever->sensitivity_deviation));
  }
  if (!cantilever) return {};
  std::string note =
      fmt::format("cantilever of {} recordings, as {}: 10 % more stiffness makes moduli {}",
                  stiffness.size(), is_stated ? "the manifest has it" : "the files have it",
                  change(0.1 * upper_median(stiffness)));
  if (upper_median(sensitivity) > 0) {
    note += ", 10 % more sensitivity " + change(0.1 * upper_median(sensitivity));
    if (upper_median(max_m) > 0)
      note += " (it is at most " + number(1e9 * upper_median(max_m)) +
              " nm per unit, or the body would be stiffer than rigid)";
  }
  const double left_open = upper_median(open);
  note += left_open > 0
              ? "; its stated deviations leave moduli open by " + number(100 * left_open) + " %"
              : "; no deviation is stated";
  return {note};
}

}  // namespace palpate::recordings
