// Springs under a body against closed forms: a rigid motion, a bar between planes of symmetry, a
// stiff block that sinks.

#include <gtest/gtest.h>

#include <random>

#include "block.hpp"
#include "libfem/elements/elastic_body.hpp"
#include "libfem/solve/equilibrium/equilibrium.hpp"
#include "tests/libfem/matrix_entries.hpp"

namespace palpate::fem {
namespace {

constexpr double kSide_m = 0.02, kArea_m2 = kSide_m * kSide_m;

QuadraticMesh cube(int cells, const std::vector<char>& is_held = {}) {
  const TetMesh base = structured_block(Vec3::Constant(kSide_m), {cells, cells, cells});
  return ungraded(base, is_held.empty() ? std::vector<char>(base.nodes.rows(), 0) : is_held);
}

BedAt under_a_face(int axis, BedStiffness stiffness) {
  return [=](const Vec3& x) { return x[axis] < 1e-6 ? stiffness : BedStiffness{}; };
}

TEST(ElasticBed, resists_a_translation_by_its_area_and_stiffness) {
  const QuadraticMesh mesh = cube(2);
  const ElasticBed bed(mesh, under_a_face(2, {1e6, 4e5}));
  const Vec3 moved(1e-4, -2e-4, 3e-4);
  Points u = Points::Zero(mesh.nodes.rows(), 3), force = u;
  u.rowwise() = moved.transpose();
  const double energy = bed.add_force(u, force);
  const Vec3 expected = kArea_m2 * Vec3(4e5, 4e5, 1e6).cwiseProduct(moved);
  EXPECT_LT((force.colwise().sum().transpose() - expected).norm(), 1e-12);
  EXPECT_NEAR(energy, expected.dot(moved) / 2, 1e-15);
}

TEST(ElasticBed, has_a_force_and_a_stiffness_that_are_the_derivatives_of_its_energy) {
  const QuadraticMesh mesh = cube(2);
  const ElasticBed bed(mesh, [](const Vec3& x) {  // a border that crosses faces
    return x[2] < 1e-6 && x[0] < 0.0123 ? BedStiffness{1e6, 2e5} : BedStiffness{};
  });
  std::mt19937 random(11);
  std::normal_distribution<double> gauss(0, 1e-4);
  const auto any = [&] {
    Points u(mesh.nodes.rows(), 3);
    for (double& value : u.reshaped()) value = gauss(random);
    return u;
  };
  const Points u = any(), du = any(), none = Points::Zero(u.rows(), 3);
  Points force = none, ahead = none, behind = none, change = none;
  bed.add_force(u, force);
  const double up = bed.add_force(u + du, ahead), down = bed.add_force(u - du, behind);
  bed.add_force(du, change);
  const double slope = force.cwiseProduct(du).sum();  // exact: the energy is quadratic
  EXPECT_NEAR(slope, (up - down) / 2, 1e-12 * std::abs(up));
  EXPECT_LT((ahead - behind - 2 * change).norm(), 1e-12 * change.norm());

  const ElasticBody body(mesh, {make_material({"neo-hookean", {kYoung_Pa, kPoisson}}, "test")}, {});
  SymmetricBlockMatrix K = body.pattern();
  bed.add_stiffness(body.free_index(), K);
  Eigen::VectorXd x(K.size());
  for (Eigen::Index n = 0; n < u.rows(); ++n) x.segment<3>(3 * body.free_index()[n]) = du.row(n);
  const Eigen::VectorXd y = dense(K) * x;
  for (Eigen::Index n = 0; n < u.rows(); ++n)
    EXPECT_LT((y.segment<3>(3 * body.free_index()[n]).transpose() - change.row(n)).norm(),
              1e-12 * change.norm());
}

// Force that presses a bar of neo-Hooke's to the stretch s, free across: P = mu (s - 1/s) +
// lambda ln J / s, and the same is zero across.
double bar_N(double stretch) {
  const double mu = kYoung_Pa / (2 * (1 + kPoisson)),
               lambda = 2 * mu * kPoisson / (1 - 2 * kPoisson);
  const auto stress = [&](double along, double across, double of) {
    return mu * (of - 1 / of) + lambda * std::log(along * across * across) / of;
  };
  double low = 1, high = 2;
  for (int k = 0; k < 60; ++k) {
    const double middle = (low + high) / 2;
    (stress(stretch, middle, middle) < 0 ? low : high) = middle;
  }
  return -kArea_m2 * stress(stretch, low, stretch);
}

// Three planes of symmetry: a quarter of a bar on a smooth base, pressed by a smooth plate.
TEST(ElasticBed, that_slides_and_hardly_gives_is_a_plane_of_symmetry) {
  const QuadraticMesh mesh = cube(3);
  const BedAt planes = [](const Vec3& x) {
    return x.minCoeff() < 1e-6 ? BedStiffness{1e10, 0} : BedStiffness{};
  };
  ProbeSpec spec;
  spec.shape = "flat";
  spec.values = {{"radius", {0.03}}, {"edge_radius", {0.003}}};
  const Probe plate = make_probe(spec, "test");
  EquilibriumOptions options;
  options.residual = 1e-6;
  ContactSettings contact;
  contact.stiffness = 20000;
  Equilibrium equilibrium(mesh, {make_material({"neo-hookean", {kYoung_Pa, kPoisson}}, "test")}, {},
                          plate, contact, options, {planes});
  const Vec3 top(kSide_m / 2, kSide_m / 2, kSide_m);
  BodyState at = equilibrium.rest({top, -Vec3::UnitZ()}), next;
  for (const double strain : {0.03, 0.06, 0.1}) {
    const ProbePose pose{top - Vec3(0, 0, strain * kSide_m), -Vec3::UnitZ()};
    ASSERT_TRUE(equilibrium.solve(at, pose, at.u, next)) << strain;
    at = next;
    EXPECT_NEAR(-at.contact.force_N.z() / bar_N(1 - strain), 1, 0.01) << strain;
  }
}

// A block a hundred times as stiff as its bed sinks by F / (k A) beside what the ball dents.
TEST(ElasticBed, lets_a_stiff_block_sink) {
  SimulationSetup setup = block_setup(0.3);
  setup.is_held.assign(setup.is_held.size(), 0);
  setup.materials[0].values[0] = 1e6;
  const double bed_N_m3 = 2e5, area_m2 = 0.06 * 0.06;
  setup.loads.bed_at = under_a_face(2, {bed_N_m3, bed_N_m3});
  const auto rows =
      Simulator(setup).press_and_drag({0.03, 0.03, 0.03}, -Vec3::UnitZ(), press_only(2), {});
  ASSERT_GT(rows.rows(), 0);
  for (Eigen::Index row = 0; row < rows.rows(); ++row) {
    ASSERT_EQ(rows.status[row], RowStatus::good);
    // Hertz on a half-space, which a block of this size is to some tenths: the dent is a twentieth.
    const double modulus = 1e6 / (1 - kPoisson * kPoisson), force_N = rows.force.row(row).norm();
    const double dent_m = std::pow(force_N * 0.75 / (modulus * std::sqrt(0.008)), 2.0 / 3);
    EXPECT_NEAR(force_N / (bed_N_m3 * area_m2) + dent_m, rows.deflection.row(row).norm(),
                0.03 * rows.deflection.row(row).norm());
  }
}

}  // namespace
}  // namespace palpate::fem
