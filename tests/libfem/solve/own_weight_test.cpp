// A body under its own weight against closed forms, and the way back to its shape at rest.

#include "libfem/solve/equilibrium/own_weight.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "block.hpp"
#include "libfem/elements/elastic_body.hpp"
#include "libfem/solve/equilibrium/equilibrium.hpp"
#include "libfem/solve/experiments/loaded_shape.hpp"
#include "libfit/core/error.hpp"
#include "reaction.hpp"

namespace palpate::fem {
namespace {

constexpr double kDensity = 1050, kGravity = 9.81;
const Vec3 kBar_m(0.02, 0.02, 0.1);

OwnWeight along_z(double acceleration) { return {Vec3(0, 0, acceleration), kDensity}; }

std::vector<Material> soft(double young_Pa, double poisson) {
  return {make_material({"neo-hookean", {young_Pa, poisson}}, "test")};
}

/// A bar of 100 mm on z = 0, where it is held.
QuadraticMesh bar(int layers, const Vec3& size_m = kBar_m) {
  const TetMesh base = structured_block(size_m, {2, 2, layers});
  return ungraded(base, held_below(base.nodes, 1e-9));
}

// A column of neo-Hooke's material with Poisson's ratio 0 keeps its breadth, and its stretch s at
// the height Z at rest follows from mu (s - 1/s) = rho a (H - Z): Simpson's rule to rounding.
double height_of_column_m(double young_Pa, double acceleration, double up_to_m) {
  const double mu = young_Pa / 2;
  const auto stretch = [&](double z) {
    const double p = kDensity * acceleration * (kBar_m[2] - z) / mu;
    return (p + std::sqrt(p * p + 4)) / 2;
  };
  const int parts = 2000;
  const double h = up_to_m / parts;
  double sum = 0;
  for (int i = 0; i < parts; ++i)
    sum += h / 6 * (stretch(i * h) + 4 * stretch((i + 0.5) * h) + stretch((i + 1) * h));
  return sum;
}

TEST(OwnWeight, is_density_times_volume_with_its_moment) {
  const QuadraticMesh mesh = bar(4);
  const OwnWeight weight{Vec3(1, -2, 9), kDensity};
  const Points force = weight_N(mesh, weight);
  const double kilograms = kDensity * kBar_m.prod();
  EXPECT_LT((force.colwise().sum().transpose() - kilograms * weight.acceleration_m_s2).norm(),
            1e-12 * kilograms);
  Vec3 moment = Vec3::Zero();
  for (Eigen::Index n = 0; n < force.rows(); ++n)
    moment += Vec3(mesh.nodes.row(n)).cross(Vec3(force.row(n)));
  const Vec3 expected = kilograms * Vec3(kBar_m / 2).cross(weight.acceleration_m_s2);
  EXPECT_LT((moment - expected).norm(), 1e-12 * expected.norm());
}

TEST(OwnWeight, shortens_and_lengthens_a_soft_column_as_the_differential_equation_says) {
  constexpr double kYoung = 3000;  // its weight is a third of that over its section
  for (const double acceleration : {-kGravity, kGravity}) {
    QuadraticMesh mesh = bar(8, {0.1, 0.1, kBar_m[2]});  // as broad as high: it does not buckle
    const std::vector<Material> materials = soft(kYoung, 0);
    const OwnWeight weight = along_z(acceleration);
    ASSERT_TRUE(bend_under_weight({materials, {}, {}, weight}, mesh).is_found());
    double largest = 0;
    for (Eigen::Index n = 0; n < mesh.nodes.rows(); ++n) {
      const double expected = height_of_column_m(kYoung, acceleration, mesh.nodes(n, 2));
      largest = std::max(largest, std::abs(mesh.loaded(n, 2) - expected));
      EXPECT_NEAR(mesh.loaded(n, 0), mesh.nodes(n, 0), 1e-6);
    }
    const double sag = std::abs(height_of_column_m(kYoung, acceleration, kBar_m[2]) - kBar_m[2]);
    EXPECT_GT(sag, 0.012);
    EXPECT_LT(largest, 2e-4 * sag) << acceleration;
  }
}

TEST(OwnWeight, of_a_thin_layer_sinks_it_by_the_confined_modulus) {
  constexpr double kThick = 0.004;
  const TetMesh base = structured_block({0.08, 0.08, kThick}, {10, 10, 2});
  QuadraticMesh mesh = ungraded(base, held_below(base.nodes, 1e-9));
  const double young = 1e6, poisson = 0.2;
  const std::vector<Material> materials = soft(young, poisson);
  const OwnWeight weight = along_z(-kGravity);
  ASSERT_TRUE(bend_under_weight({materials, {}, {}, weight}, mesh).is_found());
  const double confined = young * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson));
  const double sinks = kDensity * kGravity * kThick * kThick / (2 * confined);
  for (Eigen::Index n = 0; n < mesh.nodes.rows(); ++n)
    if ((mesh.nodes.row(n).transpose() - Vec3(0.04, 0.04, kThick)).norm() < 0.01 &&
        mesh.nodes(n, 2) > kThick - 1e-9) {
      EXPECT_NEAR(mesh.nodes(n, 2) - mesh.loaded(n, 2), sinks, 5e-3 * sinks);
    }
}

TEST(OwnWeight, is_borne_by_the_ground_and_leaves_no_force_without_touch) {
  QuadraticMesh mesh = bar(4);
  const std::vector<Material> materials = soft(5000, 0.45);
  const OwnWeight weight = along_z(kGravity);
  const WeightedBody body{materials, {}, {}, weight};
  ASSERT_TRUE(bend_under_weight(body, mesh).is_found());
  const Probe probe = make_probe(sphere_spec(0.004, 0.3), "test");
  Equilibrium equilibrium(mesh, materials, {}, probe, {}, {}, {}, weight);
  const Vec3 top(0.01, 0.01, mesh.loaded.col(2).maxCoeff() + 0.001);
  const BodyState rest = equilibrium.rest({top, -Vec3::UnitZ()});
  const Vec3 lifted = reaction(equilibrium, mesh, rest.u, Vec3::Zero(), weight).force_N;
  const double newtons = kDensity * kGravity * kBar_m.prod();
  EXPECT_LT((lifted - Vec3(0, 0, -newtons)).norm(), 1e-8 * newtons);
  BodyState beside;
  // A probe that comes nearer without touching changes nothing.
  EXPECT_TRUE(equilibrium.solve(rest, {top - Vec3(0, 0, 5e-4), -Vec3::UnitZ()}, rest.u, beside));
  EXPECT_EQ(beside.contact.force_N, Vec3(Vec3::Zero()));
}

TEST(OwnWeight, the_way_back_and_forth_gives_the_shape_that_was_given) {
  std::mt19937 random(7);
  std::normal_distribution<double> gauss(0, 1);
  for (int trial = 0; trial < 3; ++trial) {
    QuadraticMesh mesh = bar(5);
    const std::vector<Material> materials = soft(4e4, 0.45);
    OwnWeight weight = along_z(0);
    for (double& a : weight.acceleration_m_s2) a = gauss(random);
    // Aslant: this one bends to the side by several centimetres.
    weight.acceleration_m_s2 *= (trial == 0 ? 2.0 : 4.0) / weight.acceleration_m_s2.norm();
    const WeightedBody body{materials, {}, {}, weight};
    const Points given = mesh.nodes;
    const double tolerance = 1e-6;
    const LoadedSearch back = unbend(body, tolerance, {}, mesh);
    ASSERT_TRUE(back.is_found()) << "trial " << trial << " share " << back.share << " a "
                                 << weight.acceleration_m_s2.transpose();
    EXPECT_LE(back.residual_m, tolerance);
    EXPECT_LE((mesh.loaded - given).rowwise().norm().maxCoeff(), tolerance);
    const double sag = (mesh.nodes - given).rowwise().norm().maxCoeff();
    EXPECT_GT(sag, 1e-3) << trial;
    QuadraticMesh again = mesh;
    again.loaded.resize(0, 3);
    ASSERT_TRUE(bend_under_weight(body, again).is_found());
    EXPECT_LE((again.loaded - given).rowwise().norm().maxCoeff(), tolerance + 1e-9) << trial;
  }
}

TEST(OwnWeight, a_body_that_cannot_carry_itself_is_said_so) {
  QuadraticMesh mesh = bar(4);
  const std::vector<Material> materials = soft(60, 0.45);
  const OwnWeight weight = along_z(-kGravity);
  const WeightedBody body{materials, {}, {}, weight};
  const Points given = mesh.nodes;
  const LoadedSearch search = unbend(body, 1e-6, {}, mesh);
  EXPECT_FALSE(search.is_found());
  EXPECT_LT(search.share, 1);
  EXPECT_EQ(mesh.nodes, given);
  EXPECT_EQ(mesh.loaded.rows(), 0);
}

// Hung by its top, a block is drawn longer, and its tension resists a press more. To first order
// in the weight forces change in proportion to it, and with its sign.
TEST(OwnWeight, changes_the_forces_of_a_press_in_proportion_and_starts_at_the_given_surface) {
  const auto pressed = [](double acceleration) {
    SimulationSetup setup = block_setup(0);
    if (acceleration != 0) setup.weight = along_z(acceleration);
    return Simulator(std::move(setup)).press_and_drag(block_top(), -Vec3::UnitZ(), press_only(2));
  };
  const PointRows none = pressed(0), up = pressed(4), down = pressed(-4);
  EXPECT_NEAR(up.touch_offset_m, none.touch_offset_m, 2e-5);
  EXPECT_NEAR(down.touch_offset_m, none.touch_offset_m, 2e-5);
  for (std::size_t row = 0; row < 2; ++row) {
    ASSERT_EQ(up.rows[row].status, RowStatus::good);
    const double at = none.rows[row].force.norm();
    const double more = up.rows[row].force.norm() - at, less = at - down.rows[row].force.norm();
    EXPECT_GT(std::abs(more), 0.002 * at) << row;
    EXPECT_NEAR(more, less, 0.15 * std::abs(more)) << row;
  }
}

TEST(OwnWeight, is_found_on_the_base_mesh_and_told_for_any_place) {
  SimulationSetup setup = block_setup(0);
  setup.weight = along_z(-kGravity);
  const LoadedShape down = unbend_base(setup);
  EXPECT_LT(down.residual_m, 1e-7);
  for (Eigen::Index n = 0; n < setup.volume.nodes.rows(); ++n)
    EXPECT_LT((down.sag_at(setup.volume.nodes.row(n)).transpose() - down.sag().row(n)).norm(),
              1e-9);
  setup.regions_at_rest = true;
  const LoadedShape bent = bend_base(setup);
  ASSERT_EQ(bent.surface.size(), 3 * setup.surface.vertices.rows());
  for (const std::int32_t v : setup.surface.triangles.reshaped())
    EXPECT_NEAR(bent.surface[3 * v + 2], bent.sag()(v, 2), 1e-7);
  setup.materials = {{"neo-hookean", {20, kPoisson}}};
  try {
    unbend_base(setup);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.where(), "[gravity]");
    EXPECT_NE(e.fact().find("no shape at rest was found beyond"), std::string::npos);
  }
}

}  // namespace
}  // namespace palpate::fem
