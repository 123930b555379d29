#include "libfit/refine/interpolation.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>

#include "libfit/core/geometry.hpp"
#include "libfit/core/linear_algebra.hpp"
#include "libfit/core/statistics.hpp"

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

// Reads the curves of a model of rings.
class SideForceReader {
 public:
  explicit SideForceReader(const Model& model)
      : model_(model), tables_(tabulate(model.curves.basis[0])) {}

  double depth_m(int step) const { return tables_.knots.back() * (step + 1) / kComparedDepths; }
  double force_N(Eigen::Index vertex, double depth_m) const {
    return runtime::curve_value(view(tables_), normal(vertex), depth_m);
  }
  Vec3 side_N(Eigen::Index vertex, double d) const {
    const auto& control = model_.curves.control;
    return (d * d * control[runtime::kSide2].row(vertex) +
            d * d * d * control[runtime::kSide3].row(vertex))
        .transpose();
  }
  bool is_covered(const Eigen::RowVector3i& triangle) const {
    for (int k = 0; k < 3; ++k)
      if (!model_.is_covered[triangle[k]]) return false;
    return true;
  }
  // Gradient of the normal energy over a triangle at a depth [N], and twice the triangle's area
  // along its normal.
  struct Slope {
    Vec3 slope_N, normal_m2;
  };
  Slope slope(const Eigen::RowVector3i& triangle, double depth_m) const {
    std::array<Vec3, 3> corner;
    std::array<double, 3> energy_J{};
    for (int k = 0; k < 3; ++k) {
      corner[k] = model_.surface.vertices.row(triangle[k]);
      energy_J[k] = runtime::curve_energy(view(tables_), normal(triangle[k]), depth_m);
    }
    const Vec3 ab = corner[1] - corner[0], ac = corner[2] - corner[0], n = ab.cross(ac);
    return {
        ((energy_J[1] - energy_J[0]) * ac.cross(n) + (energy_J[2] - energy_J[0]) * n.cross(ab)) /
            n.squaredNorm(),
        n};
  }

 private:
  const double* normal(Eigen::Index vertex) const {
    return model_.curves.control[0].row(vertex).data();
  }

  const Model& model_;
  SplineTables tables_;
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

RelativeErrors side_mismatch(const Model& model) {
  if (model.curves.family != CurveFamily::rings) return {};
  const SideForceReader reader(model);
  const double radius_m = ball_radius_m(model.probe);
  std::vector<double> found;
  for (const auto& t : model.surface.triangles.rowwise()) {
    if (!reader.is_covered(t)) continue;
    for (int step = 0; step < kComparedDepths; ++step) {
      const double d = reader.depth_m(step);
      double force_N = 0;
      Vec3 side_N = Vec3::Zero();
      for (int k = 0; k < 3; ++k) {
        const NodeShape shape(model.curves, t[k], model.inward_normal.row(t[k]), radius_m);
        const Vec3 g = shape.across * reader.side_N(t[k], d);
        side_N += shape.stretch * (g - d * (shape.curvature * g)) / 3;
        force_N += reader.force_N(t[k], d) / 3;
      }
      const auto [slope_N, normal] = reader.slope(t, d);
      const Vec3 flat = side_N - normal * (normal.dot(side_N) / normal.squaredNorm());
      if (force_N > 0) found.push_back((slope_N - flat).norm() / force_N);
    }
  }
  if (found.empty()) return {};
  return {median(found), lower_quantile(found, 0.95), lower_quantile(found, 1)};
}

}  // namespace palpate
