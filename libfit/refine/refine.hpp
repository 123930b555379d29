#pragma once

#include <optional>
#include <vector>

#include "libfit/refine/interpolation.hpp"

namespace palpate {

/// Knowledge of the presses beside their curves.
struct RefineOptions {
  /// The round end of the tool that was pressed; none: forces do not follow the gap under it.
  std::optional<Indenter> tool = {};
  /// Points were measured: neighbours differ by more than the body does, and the surface by more
  /// than its normals show. Where leaving one out decides so, forces are kriged (M12f) and normals
  /// are blends of the points' own.
  bool is_measured = false;
};

/// Report of a refinement.
struct RefineReport {
  Triangles triangles;                  ///< test-point triangulation used, rows index the curves
  bool is_own_triangulation = false;    ///< made here; false: the body's
  std::vector<std::int32_t> left_out;   ///< test points not used: fit failed, or off the surface
  std::vector<std::int32_t> uncovered;  ///< reachable vertices that no test point answers for
  double largest_projection_m = 0;      ///< from a covered vertex to its triangle
  InterpolationChoice interpolation;    ///< the interpolation chosen, and why
  LogForces trend;                      ///< over which forces are blended, where one is used
};

/// Curves on every vertex of the fine surface by area interpolation (docs/method.md, section 7;
/// paper, equation 5 and figure 7): each reachable vertex is projected on the test-point
/// triangulation (nearest point of compatible normal, reached along the surface), and its control
/// values are the area coordinates' blend (M12), rounded to float32. Monotone curves stay monotone.
/// A vertex at a test point gets its curves unchanged. Second order in the spacing of test points.
/// test_triangles: rows index the points of `curves`; empty: triangulate_over(fine). When that
/// finds no triangle (fewer than three points, points on a line) each vertex takes the curves of
/// the point nearest along the surface. A point whose fit failed leaves its weight to the other
/// corners. One whose fit is poor stays, but counts in no choice: neither of interpolation nor for
/// the trend of shape. is_reachable: per vertex of `fine`. Vertices that are not reachable, or that
/// nothing answers for, are not covered and have zero curves. The result does not depend on the
/// order of fine triangles beyond rounding, nor on threads. Throws Error when there is no test
/// point or sizes and indices do not fit.
Model refine(const FittedCurves& curves, const Surface& fine, const std::vector<char>& is_reachable,
             const Triangles& test_triangles, const RefineOptions& options = {},
             RefineReport* report = nullptr);

/// Refines over a body: on its own triangulation when the curves' points are its test points
/// (match_triangles), else on one made for the points.
Model refine(const FittedCurves& curves, const Body& body, const RefineOptions& options = {},
             RefineReport* report = nullptr);

}  // namespace palpate
