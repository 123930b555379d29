#pragma once

#include "libfit/fit/rows/curve_rows.hpp"

namespace palpate::fit {

/// The three bases of the body in units of its `length_m`, and why. The caller scales knots.
/// A user's knots and pieces are taken; otherwise the fewest pieces are sought whose curves
/// predict held-out rows within the tolerance or, where noise forbids that, as well as the best.
/// Work: at most 64 points, evenly taken.
std::array<BasisReport, kCurveKinds> choose_bases(const BodyData& body,
                                                  std::vector<PointRows>& rows,
                                                  const FitOptions& options);

}  // namespace palpate::fit
