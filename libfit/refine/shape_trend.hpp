#pragma once

#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/refine/edge_paths.hpp"

namespace palpate {

/// What of the force at a place follows from the shape of the surface there, as a regression over
/// the test points says (M12d): interpolation then blends forces over exp(trend).
/// Empty vectors where nothing follows.
struct ShapeTrend {
  Eigen::VectorXd at_point;   ///< P: log of the force, but for a constant
  Eigen::VectorXd at_vertex;  ///< V
  bool is_used() const { return at_point.size() > 0; }
};

/// Mean curvature [1/m] and inward unit normal at each vertex and each test point. The curvature is
/// that of the normals within `radius_m` along the surface (a ring of neighbours at least), by
/// least squares: what a tool of that size feels. Columns: curvature (positive on a ball), x, y, z.
struct ShapeCovariates {
  Eigen::Matrix<double, Eigen::Dynamic, 4> at_point, at_vertex;
};
ShapeCovariates shape_covariates(const Surface& fine, const Points& outward_normal,
                                 const std::vector<char>& is_wanted,
                                 const std::vector<EdgePathSeeds>& seeds, double radius_m);

/// A trend as a function of the covariates, each scaled by its deviation over the test points and
/// kept within its range there: it is never extrapolated.
struct ShapeRegression {
  Eigen::RowVector4d mean = Eigen::RowVector4d::Zero(), scale = mean, low = mean, high = mean;
  Eigen::Vector4d slope = Eigen::Vector4d::Zero();
  double at(const Eigen::RowVector4d& x) const {
    return (x.cwiseMax(low).cwiseMin(high) - mean).cwiseProduct(scale) * slope;
  }
};

/// Ridge regression of log_force (P) on the covariates, over the points of is_used; none: a trend
/// of 0.
ShapeRegression regress_on_shape(const ShapeCovariates& covariates,
                                 const Eigen::VectorXd& log_force,
                                 const std::vector<char>& is_used);

ShapeTrend trend_over(const ShapeCovariates& covariates, const ShapeRegression& regression);

}  // namespace palpate
