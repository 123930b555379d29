#pragma once

#include "libfit/core/curves.hpp"

namespace palpate {

/// How the normal curve changes along the surface from each test point, by the side force of its
/// presses (B4a): P x 3 n, x, y, z of control value after control value [N/m]. No columns where the
/// family knows no side force.
Controls slopes_of(const FittedCurves& curves);

/// Makes control values rise: each is at least the one before.
void clamp_rising(Eigen::Ref<Eigen::RowVectorXd> control);

/// By how much side force and the slope of the normal energy disagree where the contact point
/// slides, |grad Z - S (1 - d kappa) g| over f^z (B4a): what a slide may gain, beside the mu f^z
/// that friction takes. Over triangles with three covered corners, at four depths. 0 where the
/// family knows no side force.
struct SideMismatch {
  double median = 0, p95 = 0, max = 0;
};
SideMismatch side_mismatch(const Model& model);

/// Moves the side force of each vertex, test points among them, halfway to the slope of the normal
/// energy around it: the side force of a press that sticks is not quite that of a slide. Vertices
/// with a neighbour that is not covered keep theirs. No side force stays above ten times its press.
/// Only for the rings family.
void match_slope(Model& model);

/// Of a node: the projection to its tangent plane, the curvature kappa [1/m] of the surface that
/// the tool's reference point touches along, and (1 - R kappa)^-1: how far that point moves while
/// the contact point moves by 1 (M15b).
struct NodeShape {
  Mat3 across, curvature, stretch;
  NodeShape(const CurveSet& curves, Eigen::Index row, const Vec3& normal, double radius_m);
};

}  // namespace palpate
