#pragma once

#include <array>
#include <cstdint>
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
  bool smooths = false;       ///< vertices at test points, too (M12f)
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

/// A test point, and its place as a blend of three others.
struct LeftOutPoint {
  std::int32_t point = 0;
  std::array<std::int32_t, 3> corner{};
  Vec3 weight = Vec3::Zero();
  bool has(std::int32_t other) const {
    return point == other || corner[0] == other || corner[1] == other || corner[2] == other;
  }
};

/// Ridge regression of what points have over the blends of others in their places: of log_force (P)
/// on the covariates. What changes slowly over the body, such as its thickness, is in neither; over
/// values it would drown the curvature. Rows of `without` are not used. is_used: points whose
/// covariates bound and scale it. No row: a trend of 0.
ShapeRegression regress_on_shape(const ShapeCovariates& covariates,
                                 const Eigen::VectorXd& log_force, const std::vector<char>& is_used,
                                 const std::vector<LeftOutPoint>& rows, std::int32_t without = -1);

ShapeTrend trend_over(const ShapeCovariates& covariates, const ShapeRegression& regression);

}  // namespace palpate
