#include "libfit/validation/interval.hpp"

#include <fmt/core.h>

#include <cmath>
#include <string_view>

#include "libfit/core/text.hpp"

namespace palpate::validation {

// (M11d)
std::optional<TruthInterval> truth_interval(const BodyKnowledge& known) {
  const double nu = known.poisson, mu2 = known.friction * known.friction;
  const double young = std::log1p(known.young_deviation * known.young_deviation);
  const auto squared = [](double deviation) { return deviation * deviation; };
  const double poisson = squared(2 * nu / (1 - nu * nu) * known.poisson_deviation);
  const double friction = squared(mu2 / (1 + mu2) * known.friction_deviation);
  if (!(young + poisson + friction > 0)) return std::nullopt;
  const double held = std::isfinite(known.held_share) ? squared(known.held_share) : 0;
  const double replay =
      std::isfinite(known.replay_p95_rel) ? squared(known.replay_p95_rel / 1.96) : 0;
  const double all = young + poisson + friction + held + replay;
  const double reach = 1.96 * std::sqrt(all);
  return TruthInterval{
      std::expm1(-reach), std::expm1(reach),
      young / all,        poisson / all,
      friction / all,     std::isfinite(known.held_share) ? held / all : known.held_share,
      replay / all};
}

std::string in_words(const TruthInterval& interval) {
  std::string by;
  const auto add = [&](double share, std::string_view name) {
    if (share >= 0.01)
      by += fmt::format("{} {} {}", by.empty() ? "; its causes:" : ",", percent(share, 0), name);
  };
  add(interval.young, "Young's modulus");
  add(interval.poisson, "Poisson's ratio");
  add(interval.friction, "friction");
  add(interval.held, "what is held");
  add(interval.replay, "the replay");
  if (std::isnan(interval.held)) by += "; what is held was not tried";
  return fmt::format("forces of the body itself: 95 % within {:.0f} to +{:.0f} % of the asset's{}",
                     100 * interval.low_rel, 100 * interval.high_rel, by);
}

}  // namespace palpate::validation
