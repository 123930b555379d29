#include "libfit/refine/interpolation.hpp"

#include <Eigen/Dense>
#include <algorithm>

#include "libfit/core/linear_algebra.hpp"

namespace palpate {
namespace {

// Geometry of a node: the projection to its tangent plane, the curvature kappa [1/m] of the
// surface that the tool's reference point touches along, and (1 - R kappa)^-1: how far that point
// moves while the contact point moves by 1 (M15b).
struct NodeShape {
  Mat3 across, curvature, stretch;

  NodeShape(const CurveSet& curves, Eigen::Index row, const Vec3& normal, double radius_m)
      : across(Mat3::Identity() - normal * normal.transpose()) {
    double k[6];
    for (int i = 0; i < 6; ++i) k[i] = curves.control[runtime::kCurvature](row, i);
    runtime::offset_curvature(k,
                              runtime::kCurvatureDepth * curves.basis[0].knots_m.back());  // (M15c)
    curvature << k[0], k[3], k[4], k[3], k[1], k[5], k[4], k[5], k[2];
    curvature = (across * curvature * across).eval();
    stretch = (Mat3::Identity() - radius_m * curvature).inverse();
  }
};

// Control values of d, d^2 and d^3 on a basis, a column each: exact up to its degree, else exact at
// its Greville abscissae.
Eigen::Matrix<double, Eigen::Dynamic, 3> powers_on(const CurveBasis& basis) {
  const SplineTables tables = tabulate(basis);
  const int n = basis.size();
  Eigen::MatrixXd value = Eigen::MatrixXd::Zero(n, n);
  Eigen::Matrix<double, Eigen::Dynamic, 3> wanted(n, 3);
  for (int j = 0; j < n; ++j) {
    const double x = greville_m(basis, j);
    const auto at = runtime::spline_weights(view(tables), runtime::find_piece(view(tables), x), x);
    for (int k = 0; k <= basis.degree; ++k) value(j, at.first + k) = at.value[k];
    wanted.row(j) << x, x * x, x * x * x;
  }
  return lu_solve(value, wanted);
}

}  // namespace

Controls slopes_of(const FittedCurves& fitted) {
  const CurveSet& curves = fitted.curves;
  if (curves.family != CurveFamily::rings) return Controls(curves.points(), 0);
  const Eigen::Matrix<double, Eigen::Dynamic, 3> power = powers_on(curves.basis[0]);
  Controls slopes(curves.points(), 3 * power.rows());
  for (Eigen::Index p = 0; p < curves.points(); ++p) {
    const NodeShape shape(curves, p, fitted.normal.row(p), ball_radius_m(fitted.probe));
    const Vec3 g2 = shape.across * curves.control[runtime::kSide2].row(p).transpose();
    const Vec3 g3 = shape.across * curves.control[runtime::kSide3].row(p).transpose();
    const Vec3 by_power[] = {2 * g2, 3 * (g3 - shape.curvature * g2), -4 * shape.curvature * g3};
    for (Eigen::Index j = 0; j < power.rows(); ++j) {
      Vec3 slope = Vec3::Zero();
      for (int k = 0; k < 3; ++k) slope += power(j, k) * by_power[k];
      slopes.row(p).segment<3>(3 * j) = (shape.stretch * slope).transpose();
    }
  }
  return slopes;
}

void clamp_rising(Eigen::Ref<Eigen::RowVectorXd> control) {
  for (Eigen::Index j = 1; j < control.size(); ++j)
    control[j] = std::max(control[j], control[j - 1]);
}

}  // namespace palpate
