#include "libfem/solve/experiments/displacements.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "libfem/mesh/tets.hpp"
#include "libfem/mesh/topology.hpp"
#include "libfit/core/closest_point.hpp"

namespace palpate::fem {

Waypoints transferred(const Waypoints& reached, const QuadraticMesh& from,
                      const QuadraticMesh& to) {
  if (reached.empty()) return {};
  struct NodePlace {
    std::array<std::int32_t, 10> node{};
    std::array<double, 10> shape{};  // zeros where held
  };
  std::vector<NodePlace> places(to.nodes.rows());
  const TetMesh corners{from.nodes, from.tets.leftCols<4>(), {}};
  const BoxTree boxes = boxes_of(corners.nodes, corners.tets);
  for (std::size_t n = 0; n < places.size(); ++n) {
    if (to.is_held[n]) continue;
    const auto found =
        closest_in_volume(corners, boxes, to.nodes.row(n), std::numeric_limits<double>::infinity(),
                          [](const VolumePoint&) { return true; });
    if (!found) continue;
    auto& [node, shape] = places[n];
    const Eigen::Vector4d& w = found->weight;
    for (int k = 0; k < 4; ++k) shape[k] = w[k] * (2 * w[k] - 1);
    for (int e = 0; e < 6; ++e) shape[4 + e] = 4 * w[kTetEdge[e][0]] * w[kTetEdge[e][1]];
    for (int k = 0; k < 10; ++k) node[k] = from.tets(found->tet, k);
  }
  Waypoints out = reached;
  for (std::vector<Points>& path : out)
    for (Points& u : path) {
      if (u.size() == 0) continue;
      const Points there = std::exchange(u, Points::Zero(places.size(), 3));
      for (std::size_t n = 0; n < places.size(); ++n)
        for (int k = 0; k < 10; ++k) u.row(n) += places[n].shape[k] * there.row(places[n].node[k]);
    }
  return out;
}

namespace {

// Area coordinates of corners 1 and 2 at a face's nodes, and its four flat triangles.
constexpr double kNodeR[kFaceNodes] = {0, 1, 0, 0.5, 0.5, 0};
constexpr double kNodeS[kFaceNodes] = {0, 0, 1, 0, 0.5, 0.5};
constexpr int kQuarter[4][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}};

Surface flat_boundary(const QuadraticMesh& mesh) {
  Surface flat{mesh.nodes, Triangles(4 * mesh.faces.rows(), 3)};
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
    for (int q = 0; q < 4; ++q)
      for (int k = 0; k < 3; ++k) flat.triangles(4 * f + q, k) = mesh.faces(f, kQuarter[q][k]);
  return flat;
}

}  // namespace

SurfacePlaces::SurfacePlaces(const QuadraticMesh& mesh, const Points& places,
                             const Points& outward) {
  const Surface flat = flat_boundary(mesh);
  const BoxTree boxes = triangle_boxes(flat);
  for (Eigen::Index i = 0; i < places.rows(); ++i) {
    const Vec3 place = places.row(i), normal = outward.row(i);
    const auto faces_it = [&](const SurfacePoint& hit) {
      const auto [a, b, c] = corners_of(flat, hit.triangle);
      const Vec3 area = (b - a).cross(c - a);
      return area.dot(normal) >= 0.3 * area.norm();  // a thin body's other side is never hit
    };
    std::optional<SurfacePoint> hit =
        closest_point(flat, boxes, place, std::numeric_limits<double>::infinity(), faces_it);
    if (!hit) hit = closest_point(flat, boxes, place);
    double r = 0, s = 0;
    for (int k = 0; k < 3; ++k) {
      r += hit->weight[k] * kNodeR[kQuarter[hit->triangle % 4][k]];
      s += hit->weight[k] * kNodeS[kQuarter[hit->triangle % 4][k]];
    }
    FacePlace found{{}, face_point(0, r, s).shape};
    for (int a = 0; a < kFaceNodes; ++a) found.node[a] = mesh.faces(hit->triangle / 4, a);
    places_.push_back(found);
  }
}

Eigen::VectorXf SurfacePlaces::displacement(const Points& u, double quantum_m) const {
  Eigen::VectorXf out(3 * static_cast<Eigen::Index>(places_.size()));
  for (std::size_t i = 0; i < places_.size(); ++i) {
    Vec3 moved = Vec3::Zero();
    for (int a = 0; a < kFaceNodes; ++a)
      moved += places_[i].shape[a] * u.row(places_[i].node[a]).transpose();
    for (int k = 0; k < 3; ++k)
      out[3 * static_cast<Eigen::Index>(i) + k] =
          static_cast<float>(std::round(moved[k] / quantum_m) * quantum_m);
  }
  return out;
}

}  // namespace palpate::fem
