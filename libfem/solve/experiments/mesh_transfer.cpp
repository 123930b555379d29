#include "libfem/solve/experiments/mesh_transfer.hpp"

#include <limits>

#include "libfem/mesh/closest_tet.hpp"

namespace palpate::fem {
namespace {

constexpr std::array<std::array<int, 2>, 6> kEdges{
    {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};

}  // namespace

MeshTransfer::MeshTransfer(const QuadraticMesh& from, const QuadraticMesh& to) {
  const TetMesh corners{from.nodes, from.tets.leftCols<4>(), {}};
  const BoxTree boxes = tet_boxes(corners);
  places_.resize(to.nodes.rows());
  for (std::size_t n = 0; n < places_.size(); ++n) {
    NodePlace& place = places_[n];
    place = {};
    if (to.is_held[n]) continue;
    const auto found =
        closest_in_volume(corners, boxes, to.nodes.row(n), std::numeric_limits<double>::infinity(),
                          [](const VolumePoint&) { return true; });
    if (!found) continue;
    const Eigen::Vector4d& w = found->weight;
    for (int k = 0; k < 4; ++k) place.shape[k] = w[k] * (2 * w[k] - 1);
    for (int e = 0; e < 6; ++e) place.shape[4 + e] = 4 * w[kEdges[e][0]] * w[kEdges[e][1]];
    for (int k = 0; k < 10; ++k) place.node[k] = from.tets(found->tet, k);
  }
}

Points MeshTransfer::operator()(const Points& u) const {
  Points out = Points::Zero(places_.size(), 3);
  for (std::size_t n = 0; n < places_.size(); ++n)
    for (int k = 0; k < 10; ++k) out.row(n) += places_[n].shape[k] * u.row(places_[n].node[k]);
  return out;
}

Waypoints transferred(const Waypoints& reached, const QuadraticMesh& from,
                      const QuadraticMesh& to) {
  if (reached.empty()) return {};
  const MeshTransfer transfer(from, to);
  Waypoints out = reached;
  for (std::vector<Points>& path : out)
    for (Points& u : path)
      if (u.size() > 0) u = transfer(u);
  return out;
}

}  // namespace palpate::fem
