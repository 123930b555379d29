#include "libfit/fit/fit_options.hpp"

#include <algorithm>
#include <cmath>

#include "libfit/core/error.hpp"

namespace palpate::fit {
namespace {

void require(bool holds, const char* option, const char* fact, const char* remedy) {
  if (!holds) throw Error(option, fact, remedy);
}

}  // namespace

void check_options(const FitOptions& o) {
  require(o.degree >= 0 && o.degree <= 4, "fit option degree", "is not 0 to 4",
          "Choose a degree of 1, 2, 3 or 4, or 0 to have it chosen.");
  for (const int pieces : o.pieces)
    require(pieces >= 0 && pieces <= 256, "fit option pieces", "is not 0 to 256",
            "Give a number of pieces, or 0 to have it chosen.");
  require(o.max_pieces >= 1 && o.max_pieces <= 256, "fit option max_pieces", "is not 1 to 256",
          "Allow at least one piece.");
  require(o.tolerance >= 0 && o.tolerance < 1, "fit option tolerance", "is not in [0, 1)",
          "Give a relative error such as 0.02.");
  require(o.poor_above > 0, "fit option poor_above", "is not above 0",
          "Give a relative error such as 0.07.");
  require(o.weight_floor > 0 && o.weight_floor < 1, "fit option weight_floor", "is not in (0, 1)",
          "Give a fraction of the typical force such as 0.001.");
  require(o.default_friction > 0 && std::isfinite(o.default_friction),
          "fit option default_friction", "is not above 0", "Give a friction such as 0.3.");
  require(o.default_lateral_ratio > 0 && std::isfinite(o.default_lateral_ratio),
          "fit option default_lateral_ratio", "is not above 0", "Give a ratio such as 0.67.");
  require(o.contact_deviation_m >= 0 && std::isfinite(o.contact_deviation_m),
          "fit option contact_deviation", "is negative", "Give a length such as 0.1 mm, or 0.");
  require(o.sensor_deviation > 0 && std::isfinite(o.sensor_deviation),
          "fit option sensor_deviation", "is not above 0",
          "Give a share of the force such as 0.05.");
  require(!o.smoothing || (*o.smoothing >= 0 && *o.smoothing <= kStrongestSmoothing),
          "fit option smoothing", "is not 0 to 1e12", "Give 0 for none, or a number such as 100.");
  require(o.jobs >= 0, "fit option jobs", "is negative", "Give a number of threads, or 0 for all.");
}

bool is_smoothed(const FittedCurves& curves) {
  return std::any_of(curves.smoothing.begin(), curves.smoothing.end(),
                     [](double strength) { return strength > 0; });
}

FitOptions as_before(FitOptions options) {
  const CurveSet& curves = options.warm_start->curves;
  options.degree = curves.basis[0].degree;
  for (std::size_t kind = 0; kind < curves_of(curves.family); ++kind) {
    require(curves.basis[kind].degree == options.degree, "warm start",
            "has curves of several degrees", "Fit without a warm start.");
    options.knots_m[kind] = curves.basis[kind].knots_m;
  }
  options.family = curves.family;
  return options;
}

std::optional<std::array<double, kCurveKinds>> kept_strengths(const FitOptions& options) {
  const FittedCurves* earlier = options.warm_start;
  if (earlier == nullptr || options.smoothing || earlier->smoothing_reason[0].empty())
    return std::nullopt;
  return earlier->smoothing;
}

}  // namespace palpate::fit
