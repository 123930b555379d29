#pragma once

#include <string>
#include <vector>

#include "libfit/core/geometry.hpp"

namespace palpate {

inline constexpr double kStrongestSmoothing = 1e12;

/// One candidate of the search for a strength: mean over points of the loss of rows that the curves
/// did not see, in units of those rows' variance.
struct SmoothingEvidence {
  double strength = 0;
  double heldout_loss = 0;
};

/// What smoothing over neighbouring test points did to the curves of one kind (docs/method.md,
/// section 16).
struct SmoothingReport {
  /// 0: nothing was changed. Else increments of neighbours at the graph's median distance differ by
  /// about 1 / sqrt(strength) of the body's typical increment.
  double strength = 0;
  Eigen::Index points = 0, neighbours = 0;  ///< with a band of their own; edges between them
  std::vector<SmoothingEvidence> evidence;  ///< ascending; empty where nothing was tried
  /// Part of the curves' own error, as their bands have it, that smoothing takes off rows that they
  /// did not see, and the standard error of that part.
  double gain = 0, gain_error = 0;
  /// How far curves moved, in their own standard errors: root mean square over a curve's
  /// directions.
  double median_move = 0, largest_move = 0;
  Eigen::Index largest_point = -1;
  std::string reason;  ///< a sentence
};

}  // namespace palpate
