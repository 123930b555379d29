#include "libfit/fit/options.hpp"

#include <algorithm>
#include <cmath>

#include "libfit/core/error.hpp"

namespace palpate {
namespace {

constexpr double kMinFriction = 1e-3;  // a limit curve that is zero would never stick

}  // namespace

FitOptions options_for(const Samples& samples) {
  FitOptions options;
  if (samples.probe) options.default_friction = std::max(samples.probe->friction, kMinFriction);
  if (!std::isnan(samples.poisson))
    options.default_lateral_ratio = 2 * (1 - samples.poisson) / (2 - samples.poisson);
  return options;
}

}  // namespace palpate

namespace palpate::fit {
namespace {

void require(bool holds, const char* option, const char* fact, const char* remedy) {
  if (!holds) throw Error(option, fact, remedy);
}

}  // namespace

void check_options(const FitOptions& o) {
  require(o.degree >= 1 && o.degree <= 4, "fit option degree", "is not 1 to 4",
          "Choose a degree of 1, 2, 3 or 4.");
  for (const int pieces : o.pieces)
    require(pieces >= 0 && pieces <= 256, "fit option pieces", "is not 0 to 256",
            "Give a number of pieces, or 0 to have it chosen.");
  require(o.tolerance >= 0 && o.tolerance < 1, "fit option tolerance", "is not in [0, 1)",
          "Give a relative error such as 0.02.");
  require(o.default_friction > 0 && std::isfinite(o.default_friction),
          "fit option default_friction", "is not above 0", "Give a friction such as 0.3.");
  require(o.default_lateral_ratio > 0 && std::isfinite(o.default_lateral_ratio),
          "fit option default_lateral_ratio", "is not above 0", "Give a ratio such as 0.67.");
  require(o.jobs >= 0, "fit option jobs", "is negative", "Give a number of threads, or 0 for all.");
}

}  // namespace palpate::fit
