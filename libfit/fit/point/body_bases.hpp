#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "libfit/fit/point/replay.hpp"
#include "libfit/fit/report.hpp"

namespace palpate::fit {

/// Ratio of the friction limit of a ball at zero depth to the probe's coefficient.
inline constexpr double kSlidingShare = 0.95;

/// gamma R of a ball on thick bodies of nu = 0.45; 0.12 at nu = 0.3, 0.24 at 0.49, and more on thin
/// ones (docs/validation.md, parts of the method).
inline constexpr double kSpreadOfBall = 0.2;

/// A point's ln lambda, mu_0, mu_1 and gamma of its rings, the last two in 1 / the unit of length.
using RingConstants = std::array<double, 4>;

/// The constants that a point's rings are expected to have before its drags are read, and their
/// deviation: by theory, then as the body's dragged points have them. Lengths are over the body's.
/// Each constant is a line over the logarithm of the force of a press to the end of the basis: what
/// lies deep below a point stiffens its press, and not its drags.
struct RingPrior {
  RingConstants constant{-0.405, 0.3, 0, 0}, slope{};
  bool is_of_drags = false;                     ///< else theory's
  double log_force = 0;                         ///< where the line has `constant`
  RingConstants deviation{0.3, 0.1, 0.3, 0.1};  ///< of a point

  /// Whether a press may spread rings: a ball's, of a body that does not relax.
  bool has_spread() const { return constant[3] > 0; }
  /// lambda, mu_0, mu_1 and gamma of a point with this force of a press, within their bounds.
  RingConstants at(double log_force_of_point) const {
    const double x = log_force_of_point - log_force;
    return {std::exp(constant[0] + slope[0] * x), std::max(constant[1] + slope[1] * x, 0.0),
            constant[2] + slope[2] * x, std::max(constant[3] + slope[3] * x, 0.0)};
  }
};

/// The bases of the parts of a body's family, in units of its `length_m` (plain) and in metres
/// (si).
struct BodyBases {
  CurveFamily family = CurveFamily::separable;
  std::vector<CurveBasis> plain = std::vector<CurveBasis>(kCurveKinds), si = plain;
  std::array<BasisReport, kCurveKinds> report;  ///< in metres
  RingPrior rings;                              ///< of a body of rings
};

/// The bases with their tables, over the body's length and in metres.
inline Bases plain_bases(const BodyBases& b) { return Bases(b.plain, b.family); }
inline Bases si_bases(const BodyBases& b) { return Bases(b.si, b.family); }

}  // namespace palpate::fit
