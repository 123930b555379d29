#include "libfem/mesh/fill/fill_steps.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "libfem/mesh/tets.hpp"
#include "libfem/mesh/topology.hpp"

namespace palpate {
namespace {

constexpr double kMinGainDeg = 0.02;  // less is not worth an evaluation

/// Smallest dihedral angle of the tets around a node [deg], negative when one is inside out; stops
/// at the first tet no better than `enough_deg`.
double worst_around(const TetMesh& mesh, const std::vector<std::int32_t>& around,
                    double enough_deg = -1) {
  double worst = 180;
  for (const std::int32_t t : around) {
    if (worst <= enough_deg) break;
    const TetCorners corner = corners_of(mesh, t);
    if (!(tet_volume_m3(corner) > 0)) return -1;
    worst = std::min(worst, min_dihedral_deg(corner));
  }
  return worst;
}

double mean_edge_m(const TetMesh& mesh, std::int32_t node, const std::vector<std::int32_t>& around,
                   Vec3& centre) {
  double sum = 0;
  centre.setZero();
  for (const std::int32_t t : around)
    for (int k = 0; k < 4; ++k) {
      const auto other = mesh.tets(t, k);
      if (other == node) continue;
      sum += (mesh.nodes.row(other) - mesh.nodes.row(node)).norm();
      centre += mesh.nodes.row(other).transpose();
    }
  const double count = 3.0 * static_cast<double>(around.size());
  centre /= count;
  return sum / count;
}

/// Pattern search over the axes, their diagonals and towards the middle of the neighbours.
void smooth_node(TetMesh& mesh, std::int32_t node, const std::vector<std::int32_t>& around) {
  double best = worst_around(mesh, around);
  if (best > 22) return;  // a node whose tets all pass is left alone
  Vec3 centre;
  const double edge = mean_edge_m(mesh, node, around, centre);
  Vec3 at = mesh.nodes.row(node);
  const auto accepts = [&](const Vec3& candidate) {
    const Vec3 before = mesh.nodes.row(node);
    mesh.nodes.row(node) = candidate;
    const double worst = worst_around(mesh, around, best + kMinGainDeg);
    if (worst > best + kMinGainDeg) {
      best = worst;
      return true;
    }
    mesh.nodes.row(node) = before;
    return false;
  };
  if (accepts(centre)) at = centre;
  search_place(at, edge, accepts);
}

}  // namespace

void search_place(Vec3& at, double edge_m, const std::function<bool(const Vec3&)>& accepts) {
  double step = 0.2 * edge_m;
  // Twelve rounds end the search of a node.
  for (int round = 0; round < 12 && step > 0.01 * edge_m; ++round) {
    bool has_moved = false;
    for (int direction = 0; direction < 27; ++direction) {
      const Vec3 offset(direction % 3 - 1, direction / 3 % 3 - 1, direction / 9 - 1);
      if (direction == 13) continue;
      const Vec3 candidate = at + step * offset.normalized();
      if (!accepts(candidate)) continue;
      at = candidate;
      has_moved = true;
    }
    if (!has_moved) step /= 2;
  }
}

void smooth_interior(TetMesh& mesh) {
  const auto around = cells_around(mesh.tets, mesh.nodes.rows());
  std::vector<char> is_boundary(mesh.nodes.rows(), 0);
  const Triangles boundary = fem::boundary_triangles(mesh.tets);
  for (const std::int32_t v : boundary.reshaped()) is_boundary[v] = 1;
  for (int sweep = 0; sweep < 4; ++sweep) {  // a fifth changed nothing on the liver
    std::vector<std::pair<double, std::int32_t>> order;
    for (std::size_t v = 0; v < around.size(); ++v)
      if (!is_boundary[v] && !around[v].empty())
        order.emplace_back(worst_around(mesh, around[v]), static_cast<std::int32_t>(v));
    std::sort(order.begin(), order.end());
    for (const auto& [angle, node] : order) smooth_node(mesh, node, around[node]);
  }
}

}  // namespace palpate
