// Pressure in a lumen against closed forms of a thick sphere, and its derivatives.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "block.hpp"
#include "libfem/elements/elastic_body.hpp"
#include "libfem/solve/equilibrium/equilibrium.hpp"
#include "tests/libfem/matrix_entries.hpp"

namespace palpate::fem {
namespace {

// A sphere with a void: a cube of `cells` bricks a side, a third of them through its wall, bent.
QuadraticMesh hollow_sphere(double inner_m, double outer_m, int cells = 6) {
  TetMesh solid = structured_block(Vec3::Constant(2), {cells, cells, cells});
  solid.nodes.array() -= 1;
  std::vector<std::array<std::int32_t, 4>> tets;
  for (const auto& tet : solid.tets.rowwise()) {
    Vec3 middle = Vec3::Zero();
    for (const std::int32_t n : tet) middle += solid.nodes.row(n).transpose() / 4;
    if (middle.cwiseAbs().maxCoeff() > 1.0 / 3) tets.push_back({tet[0], tet[1], tet[2], tet[3]});
  }
  const auto kept =
      renumber({tets.front().data(), 4 * tets.size()}, solid.nodes.rows(), Numbering::ascending);
  const TetMesh shell{solid.nodes(kept, Eigen::all), rows_of(tets), {}};
  QuadraticMesh mesh = ungraded(shell, std::vector<char>(kept.size(), 0));
  for (auto node : mesh.nodes.rowwise()) {
    const double ring = node.cwiseAbs().maxCoeff();
    node *= (inner_m + (outer_m - inner_m) * (ring - 1.0 / 3) * 1.5) / node.norm();
  }
  return mesh;
}

TEST(LumenPressure, has_the_volume_of_the_lumen_as_its_energy) {
  const QuadraticMesh mesh = hollow_sphere(0.02, 0.03);
  const LumenPressure lumen(mesh, 1000);
  Points none = Points::Zero(mesh.nodes.rows(), 3), force = none;
  const double ball_m3 = 4.0 / 3 * std::numbers::pi * std::pow(0.02, 3);
  // Eight quadratic faces a side of the cube that is bent to the ball.
  EXPECT_NEAR(lumen.add_force(none, force) / (-1000 * ball_m3), 1, 0.015);
  EXPECT_LT(force.colwise().sum().norm(), 1e-12);  // a closed surface
}

TEST(LumenPressure, has_a_force_and_a_stiffness_that_are_the_derivatives_of_its_energy) {
  const QuadraticMesh mesh = hollow_sphere(0.02, 0.03);
  const LumenPressure lumen(mesh, 1000);
  std::mt19937 random(7);
  std::normal_distribution<double> gauss(0, 1e-3);
  const auto any = [&] {
    Points u(mesh.nodes.rows(), 3);
    for (double& value : u.reshaped()) value = gauss(random);
    return u;
  };
  const Points u = any(), du = any(), none = Points::Zero(u.rows(), 3);
  const double h = 1e-3;
  Points force = none, ahead = none, behind = none;
  lumen.add_force(u, force);
  const double up = lumen.add_force(u + h * du, ahead), down = lumen.add_force(u - h * du, behind);
  const double slope = force.cwiseProduct(du).sum();
  EXPECT_NEAR((up - down) / (2 * h), slope, 1e-5 * std::abs(slope));
  const ElasticBody body(mesh, {make_material({"neo-hookean", {kYoung_Pa, kPoisson}}, "test")}, {});
  SymmetricBlockMatrix K = body.pattern();
  lumen.add_stiffness(u, body.free_index(), K);
  Eigen::VectorXd x(K.size());
  for (Eigen::Index n = 0; n < u.rows(); ++n) x.segment<3>(3 * body.free_index()[n]) = du.row(n);
  const Eigen::VectorXd y = dense(K) * x;
  Points change = none;
  for (Eigen::Index n = 0; n < u.rows(); ++n)
    change.row(n) = y.segment<3>(3 * body.free_index()[n]);
  EXPECT_LT((change - (ahead - behind) / (2 * h)).norm(), 1e-8 * change.norm());
}

// A neo-Hookean sphere of radii A and B, incompressible, its inside stretched by s: the pressure is
// p = mu (f(s_B) - f(s)), f(s) = 2/s + 1/(2 s^4), s_B^3 - 1 = (A/B)^3 (s^3 - 1). Source: Green and
// Zerna 1968, Theoretical Elasticity, 3.10.
struct InflatedSphere {
  double A_m = 0.02, B_m = 0.026, mu_Pa = 3000, stretch;

  double stretch_at(double R_m) const {
    return std::cbrt(1 + std::pow(A_m / R_m, 3) * (std::pow(stretch, 3) - 1));
  }
  double pressure_Pa() const {
    const auto f = [](double s) { return 2 / s + 0.5 / std::pow(s, 4); };
    return mu_Pa * (f(stretch_at(B_m)) - f(stretch));
  }
  // Energy of a shell's volume, W = mu/2 (2 s^2 + s^-4 - 3), by the midpoints of 1000 shells.
  double energy_J() const {
    const double step_m = (B_m - A_m) / 1000;
    double sum = 0;
    for (double R = A_m + step_m / 2; R < B_m; R += step_m) {
      const double s = stretch_at(R);
      sum += mu_Pa / 2 * (2 * s * s + std::pow(s, -4) - 3) * 4 * std::numbers::pi * R * R * step_m;
    }
    return sum;
  }
};

TEST(LumenPressure, is_balanced_by_the_stress_of_an_inflated_sphere) {
  for (const double stretch : {1.02, 1.1, 1.25}) {
    const InflatedSphere sphere{.stretch = stretch};
    const QuadraticMesh mesh =
        hollow_sphere(stretch * sphere.A_m, sphere.stretch_at(sphere.B_m) * sphere.B_m, 9);
    ElasticBody body(
        mesh, {make_material({"neo-hookean", {2 * sphere.mu_Pa * 1.499, 0.499}}, "test")}, {});
    const BoundaryLoads loads{[](const Vec3&) {
                                return BedStiffness{1e5, 1e5};
                              },
                              sphere.pressure_Pa()};
    balance_pressure(mesh, loads, body);
    const Points none = Points::Zero(mesh.nodes.rows(), 3);
    Points force = none, pressure = none;
    LumenPressure(mesh, loads.lumen_pressure_Pa).add_force(none, pressure);
    EXPECT_NEAR(body.add_force(none, force) / sphere.energy_J(), 1, 0.03) << stretch;
    EXPECT_LT((force + pressure).norm(), 1e-4 * pressure.norm()) << stretch;
  }
}

TEST(LumenPressure, that_no_wall_can_hold_is_refused) {
  const QuadraticMesh mesh = hollow_sphere(0.02, 0.021);
  ElasticBody body(mesh, {make_material({"neo-hookean", {3000, 0.45}}, "test")}, {});
  EXPECT_THROW(balance_pressure(mesh,
                                {[](const Vec3&) {
                                   return BedStiffness{1e5, 1e5};
                                 },
                                 1e4},
                                body),
               Error);
}

}  // namespace
}  // namespace palpate::fem
