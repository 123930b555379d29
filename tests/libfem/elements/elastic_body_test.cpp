#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <random>

#include "libfem/elements/elastic_body.hpp"
#include "libfem/materials/neo_hookean.hpp"
#include "tests/libfem/elements/derivatives.hpp"
#include "tests/libfem/materials/examples.hpp"
#include "tests/libfem/matrix_entries.hpp"
#include "tests/libfem/solve/block.hpp"

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
  for (Eigen::Index n = structured_block(kSize_m, {3, 3, 3}).nodes.rows(); n < mesh.nodes.rows();
       ++n)
    mesh.nodes.row(n) += Vec3(uniform(random), uniform(random), uniform(random)).transpose();
  return mesh;
}

const Material kTissue = make_material({"neo-hookean", {kYoung_Pa, kPoisson}}, "test");

double rest_volume_m3(const QuadraticMesh& mesh) {
  double sum = 0;
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t)
    for (const ElementPoint& point : element_points()) {
      Mat3 jacobian = Mat3::Zero();
      for (int a = 0; a < kElementNodes; ++a)
        jacobian += mesh.nodes.row(mesh.tets(t, a)).transpose() * point.by_xi.row(a);
      sum += jacobian.determinant() * point.weight / 6;
    }
  return sum;
}

ElasticBody body_of(const QuadraticMesh& mesh, const Material& material = kTissue) {
  return ElasticBody(mesh, {material}, nullptr);
}

TEST(ElasticBody, affine_displacement_stores_the_energy_density_times_the_volume) {
  for (const QuadraticMesh& mesh : {distorted_block(), bent_block()}) {
    const ElasticBody body = body_of(mesh);
    const Mat3 F = general_gradient();
    const double W = kTissue.law->evaluate(kTissue.constants, F).W;
    EXPECT_NEAR(body.energy(affine(mesh.nodes, F)) / (W * rest_volume_m3(mesh)), 1, 1e-12);
    EXPECT_NEAR(body.min_J(), F.determinant(), 1e-12);
  }
  const QuadraticMesh mesh = distorted_block();
  EXPECT_NEAR(rest_volume_m3(mesh) / kSize_m.prod(), 1, 1e-12);
}

TEST(ElasticBody, patch_test_leaves_no_force_on_inner_nodes_and_balanced_forces_outside) {
  const QuadraticMesh mesh = distorted_block();
  const ElasticBody body = body_of(mesh);
  ASSERT_GT(free_nodes(body), 100);
  const Mat3 F = general_gradient();
  Points force = Points::Zero(mesh.nodes.rows(), 3);
  body.add_force(affine(mesh.nodes, F), force);
  const double scale = force.cwiseAbs().maxCoeff();
  EXPECT_LE(free_entries(body, force).cwiseAbs().maxCoeff(), 1e-12 * scale);
  EXPECT_LE(force.colwise().sum().norm(), 1e-12 * scale);
  // Virial: sum f_a X_a^T = V P.
  const Mat3 virial = force.transpose() * mesh.nodes / rest_volume_m3(mesh);
  const Mat3 P = kTissue.law->evaluate(kTissue.constants, F).P;
  EXPECT_LE((virial - P).norm(), 1e-12 * P.norm());
}

TEST(ElasticBody, newton_finds_the_affine_patch_from_a_perturbed_start_quadratically) {
  const QuadraticMesh mesh = distorted_block();
  const ElasticBody body = body_of(mesh);
  const Points exact = affine(mesh.nodes, general_gradient());
  Points u = exact;
  add_to_free(body, free_entries(body, random_field(mesh.nodes.rows(), 0.01 * kCell_m, kSeed + 2)),
              u);
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

/// A seeded state about the general affine one, and one that is pressed flat: det F down to 0.02.
Points state_of(const QuadraticMesh& mesh, unsigned seed, bool is_flat) {
  Mat3 F = general_gradient();
  if (is_flat) F = F * Vec3(1.2, 1.1, 0.1).asDiagonal();
  return affine(mesh.nodes, F) +
         random_field(mesh.nodes.rows(), (is_flat ? 0.001 : 0.02) * kCell_m, seed);
}

const Material kWatery = make_material({"neo-hookean", {kYoung_Pa, 0.4999}}, "test");

TEST(ElasticBody, force_and_stiffness_are_derivatives_of_the_energy) {
  const QuadraticMesh mesh = bent_block();
  for (const Material& material : {kTissue, kWatery})
    for (const bool is_flat : {false, true}) {
      const unsigned seed = kSeed + (is_flat ? 5 : 0);
      SCOPED_TRACE("seed " + std::to_string(seed));
      expect_derivatives(body_of(mesh, material), state_of(mesh, seed, is_flat),
                         random_field(mesh.nodes.rows(), kCell_m, seed + 100), 1e-7, 1e-7);
    }
}

TEST(ElasticBody, geometric_scale_0_is_positive_definite_where_the_exact_tangent_is_not) {
  const QuadraticMesh mesh = bent_block();
  const ElasticBody body = body_of(mesh, kWatery);
  // 1 % of volume lost: pressures of 20 E push the exact tangent through zero.
  const Points u = affine(mesh.nodes, std::cbrt(0.99) * Mat3::Identity());
  const auto is_positive = [&](double geometric_scale) {
    Points force = Points::Zero(mesh.nodes.rows(), 3);
    SymmetricBlockMatrix K = body.pattern();
    body.add_stiffness(u, geometric_scale, force, K);
    return Eigen::LLT<Eigen::MatrixXd>(dense(K)).info() == Eigen::Success;
  };
  EXPECT_FALSE(is_positive(1));
  EXPECT_TRUE(is_positive(0));
}

TEST(ElasticBody, bounded_pressure_changes_no_stiffness_where_pressures_are_small) {
  const QuadraticMesh mesh = bent_block();
  const ElasticBody body = body_of(mesh, kWatery);
  const auto values = [&](double volume, double max_pressure) {
    Points force = Points::Zero(mesh.nodes.rows(), 3);
    SymmetricBlockMatrix K = body.pattern();
    body.add_stiffness(affine(mesh.nodes, std::cbrt(volume) * Mat3::Identity()), 1.0, force, K,
                       max_pressure);
    return K.values();
  };
  const double infinite = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(values(0.9999, 2) == values(0.9999, infinite));  // half a shear modulus
  EXPECT_FALSE(values(0.99, 2) == values(0.99, infinite));
}

TEST(ElasticBody, every_instruction_set_gives_the_same_bits) {
  const QuadraticMesh mesh = bent_block();
  ElasticBody body = body_of(mesh);
  const Points u = state_of(mesh, kSeed, false);
  std::vector<double> energies;
  std::vector<Points> forces;
  std::vector<std::vector<double>> stiffnesses;
  for (const InstructionSet set : examples::instruction_sets()) {
    body.use(set);
    forces.push_back(Points::Zero(mesh.nodes.rows(), 3));
    SymmetricBlockMatrix K = body.pattern();
    energies.push_back(body.energy(u) + body.add_stiffness(u, 0.5, forces.back(), K));
    stiffnesses.push_back(K.values());
  }
  for (std::size_t i = 1; i < energies.size(); ++i) {
    EXPECT_EQ(energies[i], energies[0]) << i;
    EXPECT_TRUE(forces[i] == forces[0]) << i;
    EXPECT_TRUE(stiffnesses[i] == stiffnesses[0]) << i;
  }
}

TEST(ElasticBody, a_rigid_motion_costs_no_energy_and_no_force) {
  const QuadraticMesh mesh = bent_block();
  const ElasticBody body = body_of(mesh);
  const Mat3 Q = Eigen::AngleAxisd(2.2, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  Points u = affine(mesh.nodes, Q);
  u.rowwise() += Vec3(0.3, -0.1, 0.2).transpose();
  Points force = Points::Zero(mesh.nodes.rows(), 3);
  const double energy = body.add_force(u, force);
  EXPECT_LE(std::abs(energy), 1e-13 * kYoung_Pa * kSize_m.prod());
  EXPECT_LE(force.cwiseAbs().maxCoeff(), 1e-12 * kYoung_Pa * kSize_m[0] * kSize_m[1]);
}

TEST(ElasticBody, each_place_is_filled_by_the_material_of_its_region) {
  const QuadraticMesh mesh =
      ungraded(structured_block(kSize_m, {2, 2, 2}), std::vector<char>(27, 0));
  const Material stiff = make_material({"neo-hookean", {5 * kYoung_Pa, 0.3}}, "test");
  const ElasticBody body(mesh, {kTissue, stiff},
                         [](const Vec3& x) { return x.x() > kSize_m.x() / 2 ? 1 : 0; });
  const Mat3 F = general_gradient();
  const double expected =
      kSize_m.prod() / 2 *
      (kTissue.law->evaluate(kTissue.constants, F).W + stiff.law->evaluate(stiff.constants, F).W);
  EXPECT_NEAR(body.energy(affine(mesh.nodes, F)) / expected, 1, 1e-12);
}

TEST(ElasticBody, energy_is_infinite_inside_out) {
  const QuadraticMesh mesh = distorted_block();
  const ElasticBody body = body_of(mesh);
  EXPECT_EQ(body.energy(affine(mesh.nodes, Vec3(-1, 1, 1).asDiagonal())),
            std::numeric_limits<double>::infinity());
  EXPECT_LT(body.min_J(), 0);
}

// Moderate strains: the laws' own suites go to the ends.
TEST(ElasticBody, elements_have_exact_derivatives_with_every_law) {
  const QuadraticMesh mesh = bent_block();
  const Mat3 F = Vec3(0.95, 1.03, 1.01).asDiagonal();
  const Points u = affine(mesh.nodes, F) + random_field(mesh.nodes.rows(), 0.01 * kCell_m, kSeed);
  for (const examples::Example& example : examples::all()) {
    SCOPED_TRACE(example.name);
    const Material material = make_material(example.parameters, "test");
    const double a = averaged_share(material);
    EXPECT_TRUE(a > 0 && a <= 1) << a;
    expect_derivatives(body_of(mesh, material), u,
                       random_field(mesh.nodes.rows(), kCell_m, kSeed + 1), 1e-7,
                       example.is_kinked_at_rest ? 1e-5 : 1e-6);
  }
}

TEST(ElasticBody, volume_change_is_averaged_over_the_points_of_one_material_only) {
  TetMesh base;
  base.nodes.resize(4, 3);
  base.nodes << 0, 0, 0, kCell_m, 0, 0, 0, kCell_m, 0, 0, 0, kCell_m;
  base.tets.resize(1, 4);
  base.tets << 0, 1, 2, 3;
  const QuadraticMesh mesh = ungraded(base, std::vector<char>(4, 0));
  const Material soft = make_material({"neo-hookean", {kYoung_Pa, 0.1}}, "test");
  // The point near corner 1 is soft.
  const auto region_at = [](const Vec3& x) { return x.x() > 0.4 * kCell_m ? 1 : 0; };
  const ElasticBody body(mesh, {kWatery, soft}, region_at);
  // All corners lie on the boundary: 4 mu stay at each point.
  const double share = 1 - 4 * kWatery.constants[0] / kWatery.constants[1];
  const Points u = random_field(mesh.nodes.rows(), 0.05 * kCell_m, kSeed);

  const double weight = std::pow(kCell_m, 3) / 24;
  double expected = 0, mean_J = 0, watery_points = 0;
  for (const ElementPoint& point : element_points()) {
    Mat3 F = Mat3::Identity();
    Vec3 X = Vec3::Zero();
    for (int a = 0; a < 10; ++a) {
      F += u.row(mesh.tets(0, a)).transpose() * point.by_xi.row(a) / kCell_m;
      X += point.shape[a] * mesh.nodes.row(mesh.tets(0, a)).transpose();
    }
    const Material& here = region_at(X) ? soft : kWatery;
    double U, U1, U2;
    NeoHookean::volumetric(here.constants.data(), F.determinant() - 1, U, U1, U2);
    expected += weight * here.law->evaluate(here.constants, F).W;
    if (&here == &soft) continue;  // one point: its own mean
    expected -= weight * share * U;
    mean_J += F.determinant();
    ++watery_points;
  }
  ASSERT_EQ(watery_points, 3);
  double U, U1, U2;
  NeoHookean::volumetric(kWatery.constants.data(), mean_J / watery_points - 1, U, U1, U2);
  expected += watery_points * weight * share * U;
  EXPECT_NEAR(body.energy(u) / expected, 1, 1e-10) << "seed " << kSeed;
}

}  // namespace
}  // namespace palpate::fem
