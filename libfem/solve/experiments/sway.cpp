#include "libfem/solve/experiments/sway.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <numbers>

#include "libfem/contact/face_rule.hpp"
#include "libfit/core/linear_algebra.hpp"

namespace palpate::fem {
namespace {

constexpr double kLeastShare = 0.1;    // of a flat ring's area
constexpr double kLeastSpread = 1e-3;  // of a ring's rigid motions: else some motion is not told
constexpr double kLeastGive = 1e-3;    // of the largest: rounding to float keeps it positive
constexpr double kCorner = -1.0 / 9, kMiddle = 4.0 / 9;  // shape functions at a face's centroid

template <class Face>
Vec3 at_centroid(const Points& rows, const Face& face) {
  Vec3 out = Vec3::Zero();
  for (int a = 0; a < kFaceNodes; ++a)
    out += (a < 3 ? kCorner : kMiddle) * rows.row(face[a]).transpose();
  return out;
}

}  // namespace

Mat3 sway_under(const QuadraticMesh& mesh, const Vec3& normal, double reach_m,
                const std::array<Points, 3>& by_axis) {
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  const double inner = kSwayInner * reach_m, outer = kSwayOuter * reach_m;
  double area_m2 = 0;
  Matrix6 square = Matrix6::Zero();
  Eigen::Matrix<double, 6, 3> right = Eigen::Matrix<double, 6, 3>::Zero();
  for (const auto& face : mesh.faces.rowwise()) {
    const Vec3 centre = at_centroid(mesh.nodes, face);
    if (!(centre.norm() >= inner && centre.norm() <= outer)) continue;
    const Vec3 a = mesh.nodes.row(face[0]), b = mesh.nodes.row(face[1]),
               c = mesh.nodes.row(face[2]);
    const Vec3 outward = (b - a).cross(c - a) / 2;
    if (!(outward.dot(normal) < 0)) continue;
    // A rotation w moves a place x by w x x; lengths over the reach.
    const Vec3 x = centre / reach_m;
    Eigen::Matrix<double, 3, 6> rigid;
    rigid.leftCols<3>().setIdentity();
    rigid.rightCols<3>() << 0, x.z(), -x.y(), -x.z(), 0, x.x(), x.y(), -x.x(), 0;
    Mat3 moved;
    for (int axis = 0; axis < 3; ++axis) moved.col(axis) = at_centroid(by_axis[axis], face);
    square += outward.norm() * rigid.transpose() * rigid;
    right += outward.norm() * rigid.transpose() * moved;
    area_m2 += outward.norm();
  }
  const double flat_m2 = std::numbers::pi * (outer * outer - inner * inner);
  if (!(area_m2 >= kLeastShare * flat_m2)) return Mat3::Zero();
  const Eigen::VectorXd spread = symmetric_eigen(Eigen::MatrixXd(square)).values;
  if (!(spread[0] > kLeastSpread * spread[5])) return Mat3::Zero();
  const Mat3 sway = square.ldlt().solve(right).topRows<3>();
  const auto [values, vectors] = symmetric_eigen(Mat3(0.5 * (sway + sway.transpose())));
  const double most = values.maxCoeff();
  if (!(most > 0)) return Mat3::Zero();
  return vectors * values.cwiseMax(kLeastGive * most).asDiagonal() * vectors.transpose();
}

}  // namespace palpate::fem
