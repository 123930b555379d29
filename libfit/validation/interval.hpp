#pragma once

#include <optional>
#include <string>

namespace palpate::validation {

/// Numbers that a body's forces follow from, with standard deviations; 0: taken as known.
struct BodyKnowledge {
  double young_deviation = 0;  ///< over Young's modulus
  double poisson = 0.5, poisson_deviation = 0;
  double friction = 0, friction_deviation = 0;  ///< the latter over the coefficient
  double held_share = 0;      ///< of a press's force, from where the body is held; NaN: not tried
  double replay_p95_rel = 0;  ///< of the statement; 0: not known yet
};

/// Sizes of forces of the body itself over those of its asset, less 1: 95 of 100 lie between low
/// and high. The others are shares of the variance of its logarithm; their sum is 1.
struct TruthInterval {
  double low_rel = 0, high_rel = 0;
  double young = 0, poisson = 0, friction = 0, held = 0, replay = 0;
};

/// None where no deviation of the material or of friction is known. The variances of ln F add up
/// (docs/method.md, M11d).
std::optional<TruthInterval> truth_interval(const BodyKnowledge& known);

/// "forces of the body itself: 95 % within -36 to +56 % of the asset's; its causes: 98 % friction".
std::string in_words(const TruthInterval& interval);

}  // namespace palpate::validation
