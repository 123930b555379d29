#include "libfem/solve/equilibrium/lumen_pressure.hpp"

#include <Eigen/Geometry>

#include "libfem/solve/equilibrium/equilibrium.hpp"
#include "libfem/solve/factor/schur_factor.hpp"
#include "libfit/core/error.hpp"

namespace palpate::fem {
namespace {

// A face adds det(x_a, x_b, x_c) to the integral of x . dA, times the part of
// int N_a dN_b/dr dN_c/ds that changes its sign with every exchange of two nodes: [a][b][c].
using VolumeShares = std::array<std::array<std::array<double, kFaceNodes>, kFaceNodes>, kFaceNodes>;

VolumeShares volume_shares() {
  const auto plain = [](int a, int b, int c) {
    double sum = 0;
    for (const FacePoint& at : kFaceRule)
      sum += at.weight * at.shape[a] * at.shape_r[b] * at.shape_s[c];
    return sum;
  };
  VolumeShares out;
  for (int a = 0; a < kFaceNodes; ++a)
    for (int b = 0; b < kFaceNodes; ++b)
      for (int c = 0; c < kFaceNodes; ++c)
        out[a][b][c] = (plain(a, b, c) + plain(b, c, a) + plain(c, a, b) - plain(a, c, b) -
                        plain(c, b, a) - plain(b, a, c)) /
                       6;
  return out;
}

const VolumeShares& shares() {
  static const VolumeShares made = volume_shares();
  return made;
}

Mat3 cross_matrix(const Vec3& x) {
  return (Mat3() << 0, -x.z(), x.y(), x.z(), 0, -x.x(), -x.y(), x.x(), 0).finished();
}

[[noreturn]] void throw_unbalanced() {
  throw Error("[body] pressure", "no shape is found that the pressure inflates to the body's",
              "Give less pressure, a thicker wall, or a stiffer material.");
}

}  // namespace

LumenPressure::LumenPressure(const QuadraticMesh& mesh, double pressure_Pa)
    : mesh_(&mesh), pressure_Pa_(pressure_Pa) {
  if (pressure_Pa == 0) return;
  const std::vector<char> is_lumen = faces_of_lumens(mesh.nodes, mesh.faces.leftCols<3>());
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f) {
    if (!is_lumen[f]) continue;
    auto& face = faces_.emplace_back();
    for (int a = 0; a < kFaceNodes; ++a) face[a] = mesh.faces(f, a);
  }
}

double LumenPressure::add_force(const Points& u, Points& force) const {
  double volume = 0;
  for (const auto& face : faces_) {
    FaceNodes x = nodes_of_face(mesh_->nodes, face);
    for (int a = 0; a < kFaceNodes; ++a) x[a] += u.row(face[a]).transpose();
    for (int a = 0; a < kFaceNodes; ++a) {
      Vec3 area = Vec3::Zero();  // derivative of the face's part of 1/3 int x . dA
      for (int b = 0; b < kFaceNodes; ++b)
        for (int c = 0; c < b; ++c) area += 2 * shares()[a][b][c] * x[b].cross(x[c]);
      force.row(face[a]) += pressure_Pa_ * area.transpose();
      volume -= x[a].dot(area) / 3;
    }
  }
  return -pressure_Pa_ * volume;
}

void LumenPressure::add_stiffness(const Points& u, const std::vector<std::int32_t>& free_index,
                                  SymmetricBlockMatrix& K) const {
  for (const auto& face : faces_) {
    FaceNodes x = nodes_of_face(mesh_->nodes, face);
    for (int a = 0; a < kFaceNodes; ++a) x[a] += u.row(face[a]).transpose();
    for (int a = 0; a < kFaceNodes; ++a)
      for (int b = 0; b < a; ++b) {  // a node's own block is zero
        const std::int32_t i = free_index[face[a]], j = free_index[face[b]];
        if (i < 0 || j < 0) continue;
        Vec3 across = Vec3::Zero();
        for (int c = 0; c < kFaceNodes; ++c) across += shares()[a][b][c] * x[c];
        const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> block =
            -2 * pressure_Pa_ * cross_matrix(across);
        K.add(K.place(i, j), block.data());
      }
  }
}

void balance_pressure(const QuadraticMesh& mesh, const BoundaryLoads& loads, ElasticBody& body) {
  const Points none = Points::Zero(mesh.nodes.rows(), 3);
  const LumenPressure lumen(mesh, loads.lumen_pressure_Pa);
  if (lumen.is_empty()) return;
  Points load = none;
  lumen.add_force(none, load);
  const ElasticBed bed(mesh, loads.bed_at);  // keeps a body that is not held from floating
  SymmetricBlockMatrix K = body.pattern();
  Points u = none, force = none;
  body.add_stiffness(none, 0, force, K);
  bed.add_stiffness(body.free_index(), K);
  SchurFactor factor;
  AndersonMixing mixing(10);
  if (!factor.factor(K, {})) throw_unbalanced();
  double first_N = 0;
  Points step = none;  // the last one, halved where it turned an element inside out
  // An ellipsoid whose walls stretch by a tenth takes 35 rounds, by a sixth 60.
  for (int round = 0; round < 100; ++round) {
    force = load;
    body.add_force(none, force);
    Eigen::VectorXd residual(K.size()), next;
    for (Eigen::Index n = 0; n < u.rows(); ++n)
      if (const std::int32_t i = body.free_index()[n]; i >= 0)
        residual.segment<3>(3 * i) = -force.row(n).transpose();
    if (first_N == 0) first_N = residual.norm();
    if (!(body.min_J() > 0)) {
      step /= 2;
      u -= step;
      mixing.reset();
    } else {
      // A contact's equilibrium takes up what is left, a displacement of a ten-thousandth.
      if (residual.norm() <= 1e-4 * first_N) return;
      factor.solve(residual, next);
      next = mixing.mix(Eigen::VectorXd(next), residual);
      mixing.record(next);
      for (Eigen::Index n = 0; n < u.rows(); ++n)
        if (const std::int32_t i = body.free_index()[n]; i >= 0)
          step.row(n) = next.segment<3>(3 * i).transpose();
      u += step;
    }
    body.strain_by(u);
  }
  throw_unbalanced();
}

}  // namespace palpate::fem
