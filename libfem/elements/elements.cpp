#include "libfem/elements/elements.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::fem {
namespace {

// Middles of the edges (0,1) (1,2) (2,0) (0,3) (1,3) (2,3) follow the corners.
constexpr std::array<std::array<int, 2>, 6> kTetEdges{
    {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};

}  // namespace

ElementKind element_for(ElementKind wanted, const Material& material) {
  if (wanted == ElementKind::automatic) wanted = ElementKind::tet10_blend;
  return averages(wanted) && !material.law->splits_volume ? ElementKind::tet10 : wanted;
}

double averaged_share(ElementKind kind, const Material& material) {
  if (kind != ElementKind::tet10_blend) return averages(kind) ? 1 : 0;
  double U, U1, U2;
  material.law->volumetric(material.constants, 0, U, U1, U2);
  const SmallStrain hooke = material.law->small_strain(material.constants);
  const double beyond_Pa = hooke.lambda_Pa - hooke.mu_Pa;
  return beyond_Pa > 0 ? std::min(1.0, beyond_Pa / U2) : 0;
}

ElementPoint element_point(const Eigen::Vector4d& L, double weight) {
  constexpr double dL[4][3] = {{-1, -1, -1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};  // dL_c/dxi_j
  ElementPoint point{L, weight, Eigen::VectorXd(kElementNodes), {}};
  point.by_xi.resize(kElementNodes, 3);
  for (int c = 0; c < 4; ++c) {
    point.shape[c] = L[c] * (2 * L[c] - 1);
    for (int j = 0; j < 3; ++j) point.by_xi(c, j) = (4 * L[c] - 1) * dL[c][j];
  }
  for (int e = 0; e < 6; ++e) {
    const int a = kTetEdges[e][0], b = kTetEdges[e][1];
    point.shape[4 + e] = 4 * L[a] * L[b];
    for (int j = 0; j < 3; ++j) point.by_xi(4 + e, j) = 4 * (L[a] * dL[b][j] + L[b] * dL[a][j]);
  }
  return point;
}

std::vector<ElementPoint> element_points() {
  constexpr double kFar = 0.138196601125010515;  // barycentric, of the three farther corners
  std::vector<ElementPoint> out;
  for (int c = 0; c < kElementPoints; ++c) {
    Eigen::Vector4d L = Eigen::Vector4d::Constant(kFar);
    L[c] = 1 - 3 * kFar;
    out.push_back(element_point(L, 0.25));
  }
  return out;
}

Eigen::VectorXd unit_constant(const Eigen::VectorXd& weight) {
  const double sum = weight.sum();
  if (!(sum > 0)) return Eigen::VectorXd::Zero(weight.size());
  return (weight.array() != 0).cast<double>() / std::sqrt(sum);
}

}  // namespace palpate::fem
