#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "libfem/materials/materials.hpp"

namespace palpate::fem {

/// How a tetrahedron of ten nodes becomes elastic energy; see kElements.
enum class ElementKind { automatic, tet10, tet10_blend, tet10_p0 };

/// An element by its name, which comparisons of elements show.
struct ElementRow {
  ElementKind kind;
  std::string_view name;
};

/// Every element there is. tet10-blend is nearest the truth under a probe at any Poisson's ratio:
/// tet10 is too stiff on coarse meshes, and tet10-p0, which averages all of the volume change, is
/// too soft. auto: tet10-blend for laws that split their bulk term off, else tet10.
inline constexpr std::array<ElementRow, 4> kElements{{{ElementKind::automatic, "auto"},
                                                      {ElementKind::tet10, "tet10"},
                                                      {ElementKind::tet10_blend, "tet10-blend"},
                                                      {ElementKind::tet10_p0, "tet10-p0"}}};

/// What is made of a material when `wanted` is asked for: itself, with `automatic` decided, and
/// tet10 in place of an element that averages where the law does not split its bulk term off.
ElementKind element_for(ElementKind wanted, const Material& material);

/// Share a of the law's U(J) that sees the averaged volume change. tet10-p0: all of it.
/// tet10-blend: all but what leaves a small-strain bulk modulus of 5/3 mu at each point, as a
/// material with lambda = mu has, so nothing locks, and what the average cannot see is as stiff as
/// a shear of the same size: a = (lambda - mu) / U''(1), within 0 and 1.
double averaged_share(ElementKind kind, const Material& material);

inline constexpr int kElementNodes = 10, kElementPoints = 4;

/// Whether the law's U(J), or a share of it, sees the mean of the volume change.
constexpr bool averages(ElementKind kind) {
  return kind == ElementKind::tet10_blend || kind == ElementKind::tet10_p0;
}

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
