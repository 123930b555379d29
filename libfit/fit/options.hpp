#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/core/statistics.hpp"

namespace palpate {

/// Unknowns of a recording beside the body's curves.
enum Nuisance : int { kContact, kBias, kDrift, kNuisances };
inline constexpr std::array<std::string_view, kNuisances> kNuisanceNames{
    "contact",  ///< where the tip touched first
    "bias",     ///< of the force along the normal
    "drift",    ///< likewise, linear from the first row to the last
};

/// What a user may decide about a fit; the defaults suit simulated samples.
struct FitOptions {
  /// None: rings where the tool was dragged, else separable.
  std::optional<CurveFamily> family{};
  /// What the body moves as a whole is taken off deflections; none: where that predicts held-out
  /// rows better.
  std::optional<bool> sways{};
  int degree = 3;  ///< of every curve, 1 to 4
  /// Pieces of the normal, lateral and limit basis; 0: the fewest that held-out rows support.
  std::array<int, kCurveKinds> pieces{0, 0, 0};
  /// Knots of each kind [m], taken as they are; empty: placed from the samples.
  std::array<std::vector<double>, kCurveKinds> knots_m{};
  /// Held-out force error that is good enough, relative; 0: as good as the rows can tell.
  double tolerance = 0.02;
  double default_friction = kDefaultFriction;  ///< L / f^z where no row slips
  /// f^r'/f^z' where no row sticks: 2 (1-nu)/(2-nu) of a half-space, here an incompressible one.
  double default_lateral_ratio = 2.0 / 3.0;
  /// Parts of each experiment's recording that are fitted with the curves, by Nuisance; each is
  /// bounded by four standard deviations of what is known of it beforehand.
  std::array<bool, kNuisances> estimates{false, false, false};
  int jobs = 0;  ///< threads, 0: all. Results do not depend on it.
  /// Curves of an earlier fit, which must outlive the call: its bases and family are kept.
  const FittedCurves* warm_start = nullptr;
  /// What that fit left: points fitted from the same rows with the same options keep their curves.
  /// Without it all are fitted again. Must outlive the call.
  const FitCache* warm_cache = nullptr;
};

/// Options with what the samples say of their probe and body, the rest at its defaults: friction,
/// and the lateral ratio of a half-space of the body's Poisson's ratio.
FitOptions options_for(const Samples& samples);

}  // namespace palpate
