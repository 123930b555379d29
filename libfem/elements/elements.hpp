#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "libfem/materials/materials.hpp"

namespace palpate::fem {

/// How a tetrahedron of ten nodes becomes elastic energy; see kElements.
enum class ElementKind { automatic, tet10, tet10_blend, tet10_p0, tet10_p1, tet4 };

/// An element that a scene names.
struct ElementRow {
  ElementKind kind;
  std::string_view name, summary;
};

/// Every element there is.
inline constexpr std::array<ElementRow, 6> kElements{{
    {ElementKind::automatic, "auto",
     "tet10-blend for laws that split their bulk term off, else tet10"},
    {ElementKind::tet10, "tet10", "ten nodes, four points; too stiff on coarse meshes"},
    {ElementKind::tet10_blend, "tet10-blend",
     "between tet10 and tet10-p0, nearest the truth under a probe at any Poisson's ratio"},
    {ElementKind::tet10_p0, "tet10-p0",
     "ten nodes, volume change averaged over the element; too soft"},
    {ElementKind::tet10_p1, "tet10-p1", "ten nodes, 14 points, volume change projected on linears"},
    {ElementKind::tet4, "tet4",
     "each ten-node element as eight linear ones; for comparison, locks"},
}};

/// The element's row. Throws Error at `where` naming the known elements.
const ElementRow& find_element(std::string_view name, const std::string& where);

/// What is made of a material when `wanted` is asked for: itself, with `automatic` decided, and
/// tet10 in place of an element that averages where the law does not split its bulk term off.
ElementKind element_for(ElementKind wanted, const Material& material);

/// Share a of the law's U(J) that sees the averaged volume change. tet10-p0, tet10-p1: all of it.
/// tet10-blend: all but what leaves a small-strain bulk modulus of 5/3 mu at each point, as a
/// material with lambda = mu has, so nothing locks, and what the average cannot see is as stiff as
/// a shear of the same size: a = (lambda - mu) / U''(1), within 0 and 1.
double averaged_share(ElementKind kind, const Material& material);

/// Numbers of an element's cells, the pieces that are integrated one by one.
/// modes: functions that the volume change is projected on, 0 where it is taken as it is.
struct ElementShape {
  int nodes, points, modes;
};
constexpr ElementShape shape_of(ElementKind kind) {
  switch (kind) {
    case ElementKind::tet4:
      return {4, 1, 0};
    case ElementKind::tet10_blend:
    case ElementKind::tet10_p0:
      return {10, 4, 1};
    case ElementKind::tet10_p1:
      return {10, 14, 4};
    default:
      return {10, 4, 0};
  }
}

/// A quadrature point of a cell. shape: N_a. by_xi: dN_a/dxi_j, barycentric coordinates 1 to 3.
/// weight: share of the cell's volume in coordinates xi, which is 1/6.
struct CellPoint {
  Eigen::Vector4d barycentric;
  double weight;
  Eigen::VectorXd shape;
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> by_xi;
};

/// The rule of an element: one point (exact to degree 1), four (2) or 14 (5).
/// Sources: Keast 1986 (doi:10.1016/0045-7825(86)90059-9); Walkington 2000, quadrature on simplices
/// of arbitrary dimension.
std::vector<CellPoint> cell_points(const ElementShape& shape);

/// Eight tets of the nodes of a ten-node one: its corners, and the octahedron between along its
/// shortest diagonal. Rows are positions within the ten. nodes: 10 x 3 [m].
std::array<std::array<int, 4>, 8> eight_tets(const Eigen::Matrix<double, 10, 3>& nodes);

/// Polynomials of degree 0 (modes 1) or 1 (modes 4) at points of a cell, orthonormal under the
/// weights: modes x points. Points of weight 0 get 0, and so does a mode that the points with
/// weight cannot tell from the others.
Eigen::MatrixXd orthonormal_modes(int modes, const std::vector<CellPoint>& points,
                                  const Eigen::VectorXd& weight);

}  // namespace palpate::fem
