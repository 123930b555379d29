#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <random>

#include "block.hpp"
#include "libfem/solve/elastic_body.hpp"

namespace palpate::fem {
namespace {

constexpr unsigned kSeed = 4711;
const Vec3 kSize_m(0.06, 0.05, 0.04);
constexpr double kCell_m = 0.02;

/// The general deformation gradient of the material references.
Mat3 general_gradient() {
  Mat3 F;
  F << 1.1, 0.25, -0.15, 0.05, 0.85, 0.3, -0.2, 0.1, 1.2;
  return F;
}

/// 3 x 3 x 3 cells with inner nodes moved by up to a fifth of a cell, all boundary nodes held.
QuadraticMesh distorted_block() {
  TetMesh base = structured_block(kSize_m, {3, 3, 3});
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> uniform(-0.2, 0.2);
  std::vector<char> is_held;
  for (Eigen::Index n = 0; n < base.nodes.rows(); ++n) {
    const Vec3 x = base.nodes.row(n);
    const Vec3 wall = x.cwiseMin(kSize_m - x);
    is_held.push_back(wall.minCoeff() < 1e-9);
    const Vec3 by(uniform(random), uniform(random), uniform(random));
    if (!is_held.back()) base.nodes.row(n) += by.cwiseProduct(kSize_m / 3).transpose();
  }
  return ungraded(base, is_held);
}

/// The same with bent edges: mid-edge nodes off the middle.
QuadraticMesh bent_block() {
  QuadraticMesh mesh = distorted_block();
  mesh.is_held = held_below(mesh.nodes, 1e-6);
  std::mt19937 random(kSeed + 1);
  std::uniform_real_distribution<double> uniform(-0.04 * kCell_m, 0.04 * kCell_m);
  for (Eigen::Index n = structured_block(kSize_m, {3, 3, 3}).nodes.rows(); n < mesh.nodes.rows(); ++n)
    mesh.nodes.row(n) += Vec3(uniform(random), uniform(random), uniform(random)).transpose();
  return mesh;
}

Points affine(const Points& nodes, const Mat3& F) {
  return nodes * (F - Mat3::Identity()).transpose();
}

Points random_field(Eigen::Index nodes, double size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-size, size);
  Points u(nodes, 3);
  for (Eigen::Index i = 0; i < u.size(); ++i) u.data()[i] = uniform(random);
  return u;
}

const Material kTissue = make_material({"neo-hookean", {kYoung_Pa, kPoisson}}, "test");

Eigen::VectorXd free_entries(const ElasticBody& body, const Points& field) {
  Eigen::VectorXd out(3 * body.free_nodes());
  for (Eigen::Index n = 0; n < field.rows(); ++n)
    if (const auto i = body.free_index()[n]; i >= 0) out.segment<3>(3 * i) = field.row(n);
  return out;
}

void add_to_free(const ElasticBody& body, const Eigen::VectorXd& by, Points& field) {
  for (Eigen::Index n = 0; n < field.rows(); ++n)
    if (const auto i = body.free_index()[n]; i >= 0)
      field.row(n) += by.segment<3>(3 * i).transpose();
}

Eigen::MatrixXd dense(const SymmetricBlockMatrix& K) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(K.size(), K.size());
  for (int c = 0; c < K.size(); ++c)
    for (auto k = K.column_start()[c]; k < K.column_start()[c + 1]; ++k)
      out(K.row_index()[k], c) = out(c, K.row_index()[k]) = K.values()[k];
  return out;
}

TEST(ElasticBody, affine_displacement_stores_the_energy_density_times_the_volume) {
  for (const QuadraticMesh& mesh : {distorted_block(), bent_block()}) {
    const ElasticBody body(mesh, {kTissue}, nullptr);
    const Mat3 F = general_gradient();
    const double W = kTissue.law->energy(kTissue.constants, F);
    EXPECT_NEAR(body.energy(affine(mesh.nodes, F)) / (W * body.rest_volume_m3()), 1, 1e-12);
    EXPECT_NEAR(body.least_J(), F.determinant(), 1e-12);
  }
  const QuadraticMesh mesh = distorted_block();
  EXPECT_NEAR(ElasticBody(mesh, {kTissue}, nullptr).rest_volume_m3() / kSize_m.prod(), 1, 1e-12);
}

TEST(ElasticBody, patch_test_leaves_no_force_on_inner_nodes_and_balanced_forces_outside) {
  const QuadraticMesh mesh = distorted_block();
  const ElasticBody body(mesh, {kTissue}, nullptr);
  ASSERT_GT(body.free_nodes(), 100);
  const Mat3 F = general_gradient();
  Points force = Points::Zero(mesh.nodes.rows(), 3);
  body.add_force(affine(mesh.nodes, F), force);
  const double scale = force.cwiseAbs().maxCoeff();
  EXPECT_LE(free_entries(body, force).cwiseAbs().maxCoeff(), 1e-12 * scale);
  EXPECT_LE(force.colwise().sum().norm(), 1e-12 * scale);
  // Virial: sum f_a X_a^T = V P.
  const Mat3 virial = force.transpose() * mesh.nodes / body.rest_volume_m3();
  const Mat3 P = kTissue.law->stress(kTissue.constants, F);
  EXPECT_LE((virial - P).norm(), 1e-12 * P.norm());
}

TEST(ElasticBody, newton_finds_the_affine_patch_from_a_perturbed_start_quadratically) {
  const QuadraticMesh mesh = distorted_block();
  const ElasticBody body(mesh, {kTissue}, nullptr);
  const Points exact = affine(mesh.nodes, general_gradient());
  Points u = exact;
  add_to_free(body,
              free_entries(body, random_field(mesh.nodes.rows(), 0.01 * kCell_m, kSeed + 2)), u);
  std::vector<double> errors;
  for (int iteration = 0; iteration < 8; ++iteration) {
    Points force = Points::Zero(mesh.nodes.rows(), 3);
    SymmetricBlockMatrix K = body.pattern();
    ASSERT_TRUE(std::isfinite(body.add_stiffness(u, 1.0, force, K))) << "seed " << kSeed;
    add_to_free(body, -dense(K).ldlt().solve(free_entries(body, force)), u);
    errors.push_back((u - exact).cwiseAbs().maxCoeff() / kSize_m.maxCoeff());
  }
  EXPECT_LE(errors.back(), 1e-12);
  for (std::size_t i = 0; i + 1 < errors.size() && errors[i] > 1e-7; ++i)
    EXPECT_LE(errors[i + 1], 1e3 * errors[i] * errors[i] + 1e-13) << i;
}

TEST(ElasticBody, force_is_the_derivative_of_energy) {
  const QuadraticMesh mesh = bent_block();
  const ElasticBody body(mesh, {kTissue}, nullptr);
  for (unsigned seed = kSeed; seed < kSeed + 5; ++seed) {
    const Points u = affine(mesh.nodes, general_gradient()) +
                     random_field(mesh.nodes.rows(), 0.02 * kCell_m, seed);
    Points force = Points::Zero(mesh.nodes.rows(), 3);
    const double energy = body.add_force(u, force);
    EXPECT_EQ(energy, body.energy(u));
    const Points d = random_field(mesh.nodes.rows(), kCell_m, seed + 100);
    const double exact = force.cwiseProduct(d).sum();
    double least = std::numeric_limits<double>::infinity();
    for (const double h : {1e-4, 1e-5, 1e-6})
      least = std::min(
          least, std::abs((body.energy(u + h * d) - body.energy(u - h * d)) / (2 * h) - exact));
    EXPECT_LE(least, 1e-7 * force.norm() * d.norm()) << "seed " << seed;
  }
}

TEST(ElasticBody, stiffness_is_the_derivative_of_force) {
  const QuadraticMesh mesh = bent_block();
  const ElasticBody body(mesh, {kTissue}, nullptr);
  for (unsigned seed = kSeed; seed < kSeed + 3; ++seed) {
    const Points u = affine(mesh.nodes, general_gradient()) +
                     random_field(mesh.nodes.rows(), 0.02 * kCell_m, seed);
    Points force = Points::Zero(mesh.nodes.rows(), 3), force_only = force;
    SymmetricBlockMatrix K = body.pattern();
    const double energy = body.add_stiffness(u, 1.0, force, K);
    EXPECT_EQ(energy, body.add_force(u, force_only));
    EXPECT_EQ((force - force_only).norm(), 0);

    Points d = Points::Zero(mesh.nodes.rows(), 3);
    const Eigen::VectorXd free_d =
        free_entries(body, random_field(mesh.nodes.rows(), kCell_m, seed + 100));
    add_to_free(body, free_d, d);
    Eigen::VectorXd exact;
    K.multiply(free_d, exact);
    double least = std::numeric_limits<double>::infinity();
    for (const double h : {1e-4, 1e-5, 1e-6}) {
      Points ahead = Points::Zero(mesh.nodes.rows(), 3), behind = ahead;
      body.add_force(u + h * d, ahead);
      body.add_force(u - h * d, behind);
      least = std::min(least, (free_entries(body, ahead - behind) / (2 * h) - exact).norm());
    }
    EXPECT_LE(least, 1e-7 * exact.norm()) << "seed " << seed;
  }
}

TEST(ElasticBody, a_rigid_motion_costs_no_energy_and_no_force) {
  const QuadraticMesh mesh = bent_block();
  const ElasticBody body(mesh, {kTissue}, nullptr);
  const Mat3 Q = Eigen::AngleAxisd(2.2, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  Points u = affine(mesh.nodes, Q);
  u.rowwise() += Vec3(0.3, -0.1, 0.2).transpose();
  Points force = Points::Zero(mesh.nodes.rows(), 3);
  const double energy = body.add_force(u, force);
  EXPECT_LE(std::abs(energy), 1e-13 * kYoung_Pa * kSize_m.prod());
  EXPECT_LE(force.cwiseAbs().maxCoeff(), 1e-12 * kYoung_Pa * kSize_m[0] * kSize_m[1]);
}

TEST(ElasticBody, each_place_is_filled_by_the_material_of_its_region) {
  const QuadraticMesh mesh = ungraded(structured_block(kSize_m, {2, 2, 2}),
                                      std::vector<char>(27, 0));
  const Material stiff = make_material({"neo-hookean", {5 * kYoung_Pa, 0.3}}, "test");
  const ElasticBody body(mesh, {kTissue, stiff},
                         [](const Vec3& x) { return x.x() > kSize_m.x() / 2 ? 1 : 0; });
  const Mat3 F = general_gradient();
  const double expected = kSize_m.prod() / 2 *
                          (kTissue.law->energy(kTissue.constants, F) +
                           stiff.law->energy(stiff.constants, F));
  EXPECT_NEAR(body.energy(affine(mesh.nodes, F)) / expected, 1, 1e-12);
}

TEST(ElasticBody, energy_is_infinite_inside_out) {
  const QuadraticMesh mesh = distorted_block();
  const ElasticBody body(mesh, {kTissue}, nullptr);
  EXPECT_EQ(body.energy(affine(mesh.nodes, Vec3(-1, 1, 1).asDiagonal())),
            std::numeric_limits<double>::infinity());
  EXPECT_LT(body.least_J(), 0);
}

}  // namespace
}  // namespace palpate::fem
