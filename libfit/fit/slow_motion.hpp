#pragma once

#include "libfit/core/curves.hpp"
#include "libfit/core/samples.hpp"

namespace palpate::fit {

/// Whether rows have times and the body's relaxation is known: curves are then fitted to what the
/// forces would be in slow motion.
inline bool feels_time(const Samples& samples) {
  return samples.time_s.size() > 0 && samples.relaxation.branches() > 0;
}

/// Samples without times whose forces, torques and errors are over what the curves answer with time
/// over what they answer in slow motion (docs/method-body.md, section 24). Rows of a press on its
/// way out, and those of which the curves say that the tool left the body behind, become
/// `no_contact`. curves: rings at the same points, of points that failed nothing is changed.
Samples in_slow_motion(const Samples& timed, const FittedCurves& curves);

}  // namespace palpate::fit
