#include "libfem/solve/experiments/surface_places.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <optional>

#include "libfit/core/closest_point.hpp"

namespace palpate::fem {
namespace {

constexpr double kMinFacing = 0.3;  // cosine: a thin body's other side is never hit

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
      const auto corner = flat.triangles.row(hit.triangle);
      const Vec3 a = flat.vertices.row(corner[0]), b = flat.vertices.row(corner[1]),
                 c = flat.vertices.row(corner[2]);
      const Vec3 area = (b - a).cross(c - a);
      return area.dot(normal) >= kMinFacing * area.norm();
    };
    constexpr double kAnywhere = std::numeric_limits<double>::infinity();
    std::optional<SurfacePoint> hit = closest_point(flat, boxes, place, kAnywhere, faces_it);
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
