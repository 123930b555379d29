#pragma once

#include <array>
#include <string>
#include <vector>

#include "libfit/core/curves.hpp"

namespace palpate {

/// What a warm start needs besides the curves of the earlier fit, so that points whose rows did not
/// change keep theirs. It saves time, never changes a result, and may be thrown away. P points.
struct FitCache {
  /// P, 16 hex digits: fingerprint of what each point was fitted from, its rows and the options.
  std::vector<std::string> fingerprint;
  /// Curves of points by their own rows alone, as `curves.control` and `covariance` of
  /// FittedCurves. No rows for a kind that was not smoothed over neighbours: its curves are these.
  std::array<Controls, kCurveKinds> own_control, own_covariance;
};

}  // namespace palpate
