#pragma once

#include <vector>

#include "libfem/materials/materials.hpp"

namespace palpate::fem {

/// Share a of the law's U(J) that sees the averaged volume change: all but what leaves a
/// small-strain bulk modulus of 5/3 mu at each point, as a material with lambda = mu has, so
/// nothing locks, and what the average cannot see is as stiff as a shear of the same size:
/// a = (lambda - mu) / U''(1), within 0 and 1.
double averaged_share(const Material& material);

inline constexpr int kElementNodes = 10, kElementPoints = 4;

/// A quadrature point of an element. shape: N_a. by_xi: dN_a/dxi_j, barycentric coordinates 1 to 3.
/// weight: share of the element's volume in coordinates xi, which is 1/6.
struct ElementPoint {
  Eigen::Vector4d barycentric;
  double weight;
  Eigen::VectorXd shape;
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> by_xi;
};

/// A point of an element at barycentric coordinates.
ElementPoint element_point(const Eigen::Vector4d& barycentric, double weight);

/// The rule of an element: four points, exact to degree 2.
/// Source: Keast 1986 (doi:10.1016/0045-7825(86)90059-9).
std::vector<ElementPoint> element_points();

/// The constant function at points, of norm 1 under the weights [m^3]: [m^-1.5], 0 at points of
/// weight 0.
Eigen::VectorXd unit_constant(const Eigen::VectorXd& weight);

}  // namespace palpate::fem
