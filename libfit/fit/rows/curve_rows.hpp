#pragma once

#include <array>

#include "libfit/fit/rows/experiments.hpp"
#include "libfit/fit/spline/monotone_least_squares.hpp"

namespace palpate::fit {

/// A point's rows by the curve that they determine when a plateau test divides stick from slip:
/// start values and evidence for a basis. The final fit does not use this division.
struct CurveRows {
  std::array<std::vector<CurveRow>, kCurveKinds> curve;
  double lateral_reach = 0;     ///< largest lateral deflection before gross slip
  double largest_friction = 0;  ///< lateral over normal force of rows that stick
  int drags = 0;                ///< experiments with a lateral deflection
  int slipping_drags = 0;       ///< drags that reach a plateau
};

/// Normal rows come from presses and drags, lateral rows from drags before their plateau, limit
/// rows from the plateau, each turned into the frame of the contact point it has then.
CurveRows curve_rows(const PointData& point);

/// Numbers rows by distinct abscissa (`share` of `range` apart) and returns how many there are.
int group_by_abscissa(std::vector<CurveRow>& rows, double range, double share);

}  // namespace palpate::fit
