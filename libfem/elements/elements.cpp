#include "libfem/elements/elements.hpp"

#include <algorithm>
#include <cmath>

#include "libfit/core/error.hpp"

namespace palpate::fem {
namespace {

// Middles of the edges (0,1) (1,2) (2,0) (0,3) (1,3) (2,3) follow the corners.
constexpr std::array<std::array<int, 2>, 6> kTetEdges{
    {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};

CellPoint point_at(const Eigen::Vector4d& L, double weight, int nodes) {
  constexpr double dL[4][3] = {{-1, -1, -1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};  // dL_c/dxi_j
  CellPoint point{L, weight, Eigen::VectorXd(nodes), {}};
  point.by_xi.resize(nodes, 3);
  for (int c = 0; c < 4; ++c) {
    point.shape[c] = nodes == 4 ? L[c] : L[c] * (2 * L[c] - 1);
    for (int j = 0; j < 3; ++j) point.by_xi(c, j) = (nodes == 4 ? 1 : 4 * L[c] - 1) * dL[c][j];
  }
  for (int e = 0; 4 + e < nodes; ++e) {
    const int a = kTetEdges[e][0], b = kTetEdges[e][1];
    point.shape[4 + e] = 4 * L[a] * L[b];
    for (int j = 0; j < 3; ++j) point.by_xi(4 + e, j) = 4 * (L[a] * dL[b][j] + L[b] * dL[a][j]);
  }
  return point;
}

/// Four points: `near` at one corner's coordinate, the rest shared by the others.
void add_corner_orbit(double far, double weight, int nodes, std::vector<CellPoint>& out) {
  for (int c = 0; c < 4; ++c) {
    Eigen::Vector4d L = Eigen::Vector4d::Constant(far);
    L[c] = 1 - 3 * far;
    out.push_back(point_at(L, weight, nodes));
  }
}

}  // namespace

const ElementRow& find_element(std::string_view name, const std::string& where) {
  std::string names;
  for (const ElementRow& row : kElements) {
    if (row.name == name) return row;
    names += (names.empty() ? "" : ", ") + std::string(row.name);
  }
  throw Error(where, "unknown element \"" + std::string(name) + "\"", "Use one of: " + names + ".");
}

ElementKind element_for(ElementKind wanted, const Material& material) {
  if (wanted == ElementKind::automatic) wanted = ElementKind::tet10_blend;
  const bool averages = shape_of(wanted).modes > 0;
  return averages && !material.law->splits_volume ? ElementKind::tet10 : wanted;
}

double averaged_share(ElementKind kind, const Material& material) {
  if (kind != ElementKind::tet10_blend) return shape_of(kind).modes > 0 ? 1 : 0;
  double U, U1, U2;
  material.law->volumetric(material.constants, 0, U, U1, U2);
  const SmallStrain hooke = material.law->small_strain(material.constants);
  const double beyond_Pa = hooke.lambda_Pa - hooke.mu_Pa;
  return beyond_Pa > 0 ? std::min(1.0, beyond_Pa / U2) : 0;
}

std::vector<CellPoint> cell_points(const ElementShape& shape) {
  std::vector<CellPoint> out;
  switch (shape.points) {
    case 1:
      return {point_at(Eigen::Vector4d::Constant(0.25), 1, shape.nodes)};
    case 4:
      add_corner_orbit(0.138196601125010515, 0.25, shape.nodes, out);
      return out;
    default:
      add_corner_orbit(0.310885919263300610, 0.112687925718015850, shape.nodes, out);
      add_corner_orbit(0.0927352503108912264, 0.0734930431163619495, shape.nodes, out);
      for (const auto& edge : kTetEdges) {
        Eigen::Vector4d L = Eigen::Vector4d::Constant(0.5 - 0.0455037041256496495);
        L[edge[0]] = L[edge[1]] = 0.0455037041256496495;
        out.push_back(point_at(L, 0.0425460207770814664, shape.nodes));
      }
      return out;
  }
}

std::array<std::array<int, 4>, 8> eight_tets(const Eigen::Matrix<double, 10, 3>& nodes) {
  // A diagonal joins middles of opposite edges; the other four middles ring it in positive order.
  struct Split {
    int from, to, ring[4];
  };
  constexpr Split kSplits[3] = {{4, 9, {5, 6, 7, 8}}, {5, 7, {4, 8, 9, 6}}, {6, 8, {4, 5, 9, 7}}};
  const Split* best = kSplits;
  const auto length = [&](const Split& s) { return (nodes.row(s.from) - nodes.row(s.to)).norm(); };
  for (const Split& split : kSplits)
    if (length(split) < (1 - 1e-9) * length(*best)) best = &split;
  std::array<std::array<int, 4>, 8> out{
      {{0, 4, 6, 7}, {4, 1, 5, 8}, {6, 5, 2, 9}, {7, 8, 9, 3}, {}, {}, {}, {}}};
  for (int k = 0; k < 4; ++k)
    out[4 + k] = {best->from, best->to, best->ring[k], best->ring[(k + 1) % 4]};
  return out;
}

Eigen::MatrixXd orthonormal_modes(int modes, const std::vector<CellPoint>& points,
                                  const Eigen::VectorXd& weight) {
  constexpr double kIndependent =
      1e-6;  // of a function's own size; four of the rules' points reach 0.1
  const auto count = static_cast<Eigen::Index>(points.size());
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(modes, count);
  for (int m = 0; m < modes; ++m) {
    Eigen::RowVectorXd f(count);
    for (Eigen::Index q = 0; q < count; ++q)
      f[q] = weight[q] == 0 ? 0.0 : m == 0 ? 1.0 : points[q].barycentric[m];
    const auto norm = [&] { return std::sqrt(f.cwiseAbs2().dot(weight)); };
    const double before = norm();
    for (int pass = 0; pass < 2; ++pass)
      for (int k = 0; k < m; ++k)
        f -= f.cwiseProduct(weight.transpose()).dot(out.row(k)) * out.row(k);
    if (norm() > kIndependent * before) out.row(m) = f / norm();
  }
  return out;
}

}  // namespace palpate::fem
