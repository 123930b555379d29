#pragma once

#include <optional>

#include "libfit/fit/report.hpp"
#include "libfit/fit/rows/curve_rows.hpp"

namespace palpate::fit {

/// The three bases of the body in units of its `length_m`, and why. The caller scales knots.
/// A user's knots and pieces are taken; otherwise the fewest pieces are sought whose curves
/// predict held-out rows within the tolerance or, where noise forbids that, as well as the best.
/// Work: at most 64 points, evenly taken.
std::array<BasisReport, kCurveKinds> choose_bases(const BodyData& body,
                                                  std::vector<CurveRows>& rows,
                                                  const FitOptions& options);

/// The basis of f^z for a law that reads its curvature, in units of the body's `length_m`: the
/// fewest pieces whose curves predict held-out rows of presses as well as the best, to a standard
/// error or the floor of the rows' weights, whatever the tolerance. Rows of drags do not count:
/// beside the point the force is not f^z alone. None where the user decides the normal basis or no
/// point presses enough to hold rows out.
std::optional<BasisReport> choose_bed_basis(const std::vector<CurveRows>& rows,
                                            const FitOptions& options);

}  // namespace palpate::fit
