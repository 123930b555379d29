#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "data/generators/structured_block.hpp"
#include "record.hpp"
#include "static_problem.hpp"

// Closed forms and independently computed references. Case ids are those of the references.

namespace palpate::fem {
namespace {

using validation::record_case;

constexpr double kPi = 3.14159265358979323846;
constexpr double kWall = 3;

Material neo_hookean(double mu_Pa, double lambda_Pa) {
  return make_material({"neo-hookean",
                        {mu_Pa * (3 * lambda_Pa + 2 * mu_Pa) / (lambda_Pa + mu_Pa),
                         lambda_Pa / (2 * (lambda_Pa + mu_Pa))}},
                       "test");
}

Vec3 same(const Vec3& X) { return X; }
auto in_plane(int axis, double at) {
  return [=](const Vec3& X) { return std::abs(X[axis] - at) < 1e-9; };
}
bool anywhere(const Vec3&) { return true; }

Eigen::Index node_at(const QuadraticMesh& mesh, const Vec3& X) {
  Eigen::Index at = 0;
  (mesh.nodes.rowwise() - X.transpose()).rowwise().norm().minCoeff(&at);
  return at;
}

double report(const std::string& id, const std::string& mesh, double reference, double ours,
              const std::string& unit, double cost) {
  const double error = reference == 0 ? ours : ours / reference - 1;
  std::printf("  %-34s %-10s %12.6g %12.6g %+9.3f %% %7.2f s\n", id.c_str(), mesh.c_str(),
              reference, ours, 100 * error, cost);
  record_case(id + " " + mesh, reference, ours, unit, error, cost);
  return error;
}

/// A unit cube in n^3 x 6 tets, inner corners moved by up to a fifth of a cell.
TetMesh distorted_cube(int n, unsigned seed) {
  TetMesh mesh = structured_block(Vec3::Ones(), {n, n, n});
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-0.2 / n, 0.2 / n);
  for (Eigen::Index i = 0; i < mesh.nodes.rows(); ++i) {
    const Vec3 by(uniform(random), uniform(random), uniform(random));
    const Vec3 X = mesh.nodes.row(i);
    if (X.cwiseMin(Vec3::Ones() - X).minCoeff() > 1e-9) mesh.nodes.row(i) += by.transpose();
  }
  return mesh;
}

TEST(Elasticity, patch_of_distorted_elements_takes_the_affine_field_of_its_boundary) {
  constexpr unsigned kSeed = 77;
  Mat3 F;
  F << 1.1, 0.25, -0.15, 0.05, 0.85, 0.3, -0.2, 0.1, 1.2;
  StaticProblem problem(quadratic(distorted_cube(3, kSeed), same), neo_hookean(1.0 / 3, 3));
  const Points exact = problem.mesh.nodes * (F - Mat3::Identity()).transpose();
  for (Eigen::Index n = 0; n < exact.rows(); ++n) {
    const Vec3 X = problem.mesh.nodes.row(n);
    if (X.cwiseMin(Vec3::Ones() - X).minCoeff() < 1e-9)
      problem.prescribed.segment<3>(3 * n) = exact.row(n).transpose();
  }
  const StaticOutcome out = solve(problem, 2);
  ASSERT_TRUE(out.is_solved) << "seed " << kSeed;
  const double error = (out.u - exact).cwiseAbs().maxCoeff();
  EXPECT_LE(error, 1e-12) << "seed " << kSeed;
  record_case("PATCH/T4_T10_affine 3^3", 0, error, "", error, out.cpu_s);
  const Mat3 P = problem.material.law->evaluate(problem.material.constants, F).P;
  EXPECT_LE((out.reaction.transpose() * problem.mesh.nodes - P).norm(), 1e-11);
}

TEST(Elasticity, dead_traction_stretches_a_cube_as_the_uniaxial_state_says) {
  struct State {
    double stretch, lateral, P11;
  };
  for (const State s : {State{0.7, 1.17085254692776, -0.419474136498678},
                        State{0.85, 1.07527913273511, -0.170088318939436},
                        State{1.2, 0.920634369846045, 0.164564543627271},
                        State{1.6, 0.806101030462563, 0.397958568476499}}) {
    StaticProblem problem(quadratic(distorted_cube(2, 5), same), neo_hookean(1.0 / 3, 3));
    for (int axis = 0; axis < 3; ++axis) problem.prescribe(in_plane(axis, 0), axis);
    problem.add_traction(in_plane(0, 1), s.P11 * Vec3::UnitX());
    const StaticOutcome out = solve(problem, 4);
    ASSERT_TRUE(out.is_solved) << s.stretch;
    const Vec3 corner = Vec3::Ones() + out.u.row(node_at(problem.mesh, Vec3::Ones())).transpose();
    char id[32];
    std::snprintf(id, sizeof id, "UNI/NH_ln/%g", s.stretch);
    const double error = report(id, "2^3", s.stretch, corner.x(), "", out.cpu_s);
    EXPECT_LE(std::abs(error), 1e-8);
    EXPECT_NEAR(corner.y() / s.lateral, 1, 1e-8);
    EXPECT_NEAR(corner.z() / s.lateral, 1, 1e-8);
  }
}

// FE/mms/problem: displacement, deformation gradient, and the body force that balances it.
Vec3 manufactured(const Vec3& X) {
  const double x = X.x(), y = X.y(), z = X.z();
  return {(z / 2 + 1) * std::sin(kPi * x / 2) * std::cos(kPi * y / 2) / 10,
          3 * (y / 3 + 1) * std::sin(kPi * z / 2) * std::cos(kPi * x / 2) / 40,
          -2 * (z * z / 2 + z) * std::sin(kPi * (x / 3 + y / 3)) / 25};
}

Mat3 manufactured_gradient(const Vec3& X) {
  const double x = X.x(), y = X.y(), z = X.z(), h = kPi / 2, t = kPi / 3;
  const double s = std::sin(t * (x + y)), c = std::cos(t * (x + y));
  Mat3 F;
  F << (z / 2 + 1) * h * std::cos(h * x) * std::cos(h * y) / 10,
      -(z / 2 + 1) * h * std::sin(h * x) * std::sin(h * y) / 10,
      std::sin(h * x) * std::cos(h * y) / 20,
      -3 * (y / 3 + 1) * std::sin(h * z) * h * std::sin(h * x) / 40,
      std::sin(h * z) * std::cos(h * x) / 40,
      3 * (y / 3 + 1) * h * std::cos(h * z) * std::cos(h * x) / 40,
      -2 * (z * z / 2 + z) * t * c / 25, -2 * (z * z / 2 + z) * t * c / 25, -2 * (z + 1) * s / 25;
  return F + Mat3::Identity();
}

/// -Div P, by differences of the exact P of fourth order.
Vec3 manufactured_body_force(const Material& material, const Vec3& X) {
  constexpr double kStep = 1e-3;
  const auto P = [&](const Vec3& at) {
    return material.law->evaluate(material.constants, manufactured_gradient(at)).P;
  };
  Vec3 out = Vec3::Zero();
  for (int j = 0; j < 3; ++j) {
    const Vec3 d = kStep * Vec3::Unit(j);
    out -= (8 * (P(X + d) - P(X - d)) - (P(X + 2 * d) - P(X - 2 * d))).col(j) / (12 * kStep);
  }
  return out;
}

TEST(Elasticity, manufactured_problem_is_the_reference_one) {
  const Material material = neo_hookean(1.0 / 3, 1);
  struct Sample {
    Vec3 X, u, B;
  };
  for (const Sample& s : {Sample{{0.2, 0.3, 0.7},
                                 {0.03717038133987637, 0.06991029877349451, -0.0378},
                                 {0.3025068590518593, 0.42570873408013105, -0.0698477372728042}},
                          Sample{{0.5, 0.5, 0.5},
                                 {0.0625, 0.04375, -0.043301270189221926},
                                 {0.4373823389001764, 0.4061976506383955, 0.0013817660096068184}},
                          Sample{{0.91, 0.13, 0.42},
                                 {0.11730390359164106, 0.00675761983571993, -0.03602949271722426},
                                 {0.7215800652390104, 0.16582793906321822, 0.07132002856750091}}}) {
    EXPECT_LE((manufactured(s.X) - s.u).norm(), 1e-14);
    EXPECT_LE((manufactured_body_force(material, s.X) - s.B).norm(), 1e-9);
  }
}

TEST(Elasticity, errors_of_a_manufactured_solution_fall_with_the_order_of_the_element) {
  double before = 0, order = 0;
  for (const int n : {2, 4, 6, 8}) {
    StaticProblem problem(quadratic(structured_block(Vec3::Ones(), {n, n, n}), same),
                          neo_hookean(1.0 / 3, 1));
    const auto on_boundary = [](const Vec3& X) {
      return X.cwiseMin(Vec3::Ones() - X).minCoeff() < 1e-9;
    };
    for (Eigen::Index i = 0; i < problem.mesh.nodes.rows(); ++i) {
      const Vec3 X = problem.mesh.nodes.row(i);
      if (on_boundary(X)) problem.prescribed.segment<3>(3 * i) = manufactured(X);
    }
    problem.add_body_force(
        [&](const Vec3& X) { return manufactured_body_force(problem.material, X); });
    const StaticOutcome out = solve(problem, 1);
    ASSERT_TRUE(out.is_solved) << "n " << n;
    const double error = l2_error(problem, out.u, manufactured);
    if (n > 2) order = std::log(before / error) / std::log(double(n) / (n - 2));
    std::printf("  n %d: L2 error %.3e, order %.2f\n", n, error, order);
    before = error;
  }
  constexpr double expected = 3;
  record_case("FE/mms/order_L2", expected, order, "", order / expected - 1, 0);
  // An average over the element takes pressure as constant there, which is of order 2.
  EXPECT_GT(order, 1.8);
  EXPECT_LT(order, expected + 0.2);
}

/// An eighth of a thick sphere: n^2 triangles of the octant, n_r layers.
/// Parameters: direction in barycentric coordinates (x, y), radius z.
TetMesh sphere_sector(int n, int layers, double inner, double outer) {
  TetMesh mesh;
  const int per_layer = (n + 1) * (n + 2) / 2;
  const auto node = [&](int i, int j, int layer) {
    return layer * per_layer + i * (n + 1) - i * (i - 1) / 2 + j;
  };
  mesh.nodes.resize(per_layer * (layers + 1), 3);
  for (int l = 0; l <= layers; ++l)
    for (int i = 0; i <= n; ++i)
      for (int j = 0; i + j <= n; ++j)
        mesh.nodes.row(node(i, j, l)) << double(i) / n, double(j) / n,
            inner * std::pow(outer / inner, double(l) / layers);
  std::vector<std::array<int, 3>> triangles;
  for (int i = 0; i < n; ++i)
    for (int j = 0; i + j < n; ++j) {
      triangles.push_back({node(i, j, 0), node(i + 1, j, 0), node(i, j + 1, 0)});
      if (i + j + 1 < n)
        triangles.push_back({node(i + 1, j, 0), node(i + 1, j + 1, 0), node(i, j + 1, 0)});
    }
  mesh.tets.resize(static_cast<Eigen::Index>(3 * triangles.size()) * layers, 4);
  Eigen::Index row = 0;
  for (int l = 0; l < layers; ++l)
    for (auto t : triangles) {
      std::sort(t.begin(), t.end());  // prisms split alike on both sides of a wall
      const int a = l * per_layer, b = a + per_layer;
      for (std::array<int, 4> tet : {std::array<int, 4>{t[0] + a, t[1] + a, t[2] + a, t[2] + b},
                                     std::array<int, 4>{t[0] + a, t[1] + a, t[1] + b, t[2] + b},
                                     std::array<int, 4>{t[0] + a, t[0] + b, t[1] + b, t[2] + b}}) {
        Mat3 edges;
        for (int k = 0; k < 3; ++k)
          edges.col(k) = mesh.nodes.row(tet[k + 1]) - mesh.nodes.row(tet[0]);
        if (edges.determinant() < 0) std::swap(tet[2], tet[3]);
        mesh.tets.row(row++) << tet[0], tet[1], tet[2], tet[3];
      }
    }
  return mesh;
}

Vec3 on_sphere(const Vec3& p) { return p.z() * Vec3(p.x(), p.y(), 1 - p.x() - p.y()).normalized(); }

// The inner surface is moved to radius a; its pressure is the work of the reaction per volume
// swept.
TEST(Elasticity, thick_sphere_swells_under_the_pressure_of_the_closed_form) {
  struct State {
    double poisson, a, p, b;
  };
  for (const State s : {State{0.3, 1.5, 0.7005488621102665, 2.2347046813443066},
                        State{0.45, 1.5, 0.7427431583794347, 2.1932796635998804},
                        State{0.49, 1.5, 0.7529526129191866, 2.1834212224268064},
                        State{0.4999, 1.25, 0.5518498327184367, 2.0764795983366495},
                        State{0.4999, 1.5, 0.7554084567238757, 2.18105903928128}}) {
    const int n = 4, layers = 4;
    StaticProblem problem(quadratic(sphere_sector(n, layers, 1, 2), on_sphere),
                          make_material({"neo-hookean", {2 * (1 + s.poisson), s.poisson}}, "test"));
    for (int axis = 0; axis < 3; ++axis) problem.prescribe(in_plane(axis, 0), axis);
    double share = 0;
    for (Eigen::Index i = 0; i < problem.mesh.nodes.rows(); ++i) {
      const Vec3 X = problem.mesh.nodes.row(i);
      if (std::abs(X.norm() - 1) < 1e-9) problem.prescribed.segment<3>(3 * i) = (s.a - 1) * X;
    }
    const StaticOutcome out = solve(problem, 4);
    ASSERT_TRUE(out.is_solved) << s.poisson;
    for (Eigen::Index i = 0; i < problem.mesh.nodes.rows(); ++i) {
      const Vec3 X = problem.mesh.nodes.row(i);
      if (std::abs(X.norm() - 1) < 1e-9) share += out.reaction.row(i).dot(X.transpose());
    }
    const double pressure = share / (kPi / 2 * s.a * s.a);
    const Eigen::Index outer = node_at(problem.mesh, 2 * Vec3::Ones().normalized());
    const double b = 2 + out.u.row(outer).norm();
    char id[64];
    std::snprintf(id, sizeof id, "FE/thick_sphere nu%g a%g p", s.poisson, s.a);
    const double error = report(id, "4x4x4", s.p, pressure, "mu", out.cpu_s);
    EXPECT_LE(std::abs(error), 0.01) << id;
    EXPECT_NEAR(b / s.b, 1, 1e-3) << id;
  }
}

/// Cook's membrane in plane strain, one layer of cells: units mm, N, MPa.
StaticProblem cook(const Material& material, double shear_MPa, int n) {
  StaticProblem problem(quadratic(structured_block(Vec3(1, 1, 1.0 / n), {n, n, 1}),
                                  [](const Vec3& p) {
                                    return Vec3(48 * p.x(), 44 * p.x() + p.y() * (44 - 28 * p.x()),
                                                48 * p.z());
                                  }),
                        material);
  for (int axis = 0; axis < 3; ++axis) problem.prescribe(in_plane(0, 0), axis);
  problem.prescribe(anywhere, 2);
  problem.add_traction(in_plane(0, 48), shear_MPa * Vec3::UnitY());
  return problem;
}

TEST(Elasticity, cooks_membrane_rises_as_the_reference) {
  struct State {
    const char* id;
    Material material;
    double shear_MPa, reference_mm;
    double allowed;
  };
  const Material stiff = neo_hookean(80.1938, 400889.8);
  for (const State& s :
       {State{"FE/cook nu0.3 t6.25", make_material({"neo-hookean", {240.565, 0.3}}, "test"), 6.25,
              7.781, 0.01},
        State{"FE/cook nu0.4999 t6.25", stiff, 6.25, 6.933, 0.01},
        State{"FE/cook nu0.4999 t24", stiff, 24, 18.20, 0.01}})
    for (const int n : {8, 16}) {
      const StaticProblem problem = cook(s.material, s.shear_MPa, n);
      const StaticOutcome out = solve(problem, 4);
      ASSERT_TRUE(out.is_solved) << s.id;
      const double uy = out.u(node_at(problem.mesh, Vec3(48, 60, 0)), 1);
      const double error =
          report(s.id, std::to_string(n) + "^2", s.reference_mm, uy, "mm", out.cpu_s);
      EXPECT_LE(std::abs(error), n == 16 ? s.allowed : 1) << s.id;
    }
}

/// A quarter of the block of Reese and Wriggers: 50 x 50 x 50 mm, top held sideways, a dead load
/// on its inner 25 x 25 mm. Units mm, N, MPa.
StaticProblem pressed_block(double q_MPa, int n) {
  StaticProblem problem(quadratic(structured_block(Vec3::Constant(50), {n, n, n}), same),
                        neo_hookean(80.194, 400889.806));
  problem.prescribe(in_plane(0, 0), 0), problem.prescribe(in_plane(1, 0), 1);
  problem.prescribe(in_plane(2, 0), 2);
  problem.prescribe(in_plane(2, 50), 0), problem.prescribe(in_plane(2, 50), 1);
  problem.add_traction(
      [](const Vec3& X) {
        return std::abs(X.z() - 50) < 1e-9 && X.x() < 25 + 1e-9 && X.y() < 25 + 1e-9;
      },
      -q_MPa * Vec3::UnitZ());
  return problem;
}

TEST(Elasticity, block_under_a_partial_load_sinks_as_the_reference) {
  struct State {
    double q_MPa, reference,
        allowed;  // the reference's own last step is 0.05 % at 80, 0.1 % at 320
  };
  for (const auto& [q, reference, allowed] : {State{80, 21.97, 0.01}, State{320, 69.33, 0.015}})
    for (const int n : {4, 8}) {
      const StaticProblem problem = pressed_block(q, n);
      const StaticOutcome out = solve(problem, static_cast<int>(q / 20));
      char id[32];
      std::snprintf(id, sizeof id, "FE/block q%g", q);
      ASSERT_TRUE(out.is_solved) << id << " n " << n;
      const double sunk = -100 * out.u(node_at(problem.mesh, Vec3(0, 0, 50)), 2) / 50;
      const double error = report(id, std::to_string(n) + "^3", reference, sunk, "%", out.cpu_s);
      EXPECT_LE(std::abs(error), n == 8 ? allowed : 1) << id;
    }
}

/// A wall of thickness 3, one element thick, in plane strain, E 1; loads are so small that it is
/// linear. size_x: of the parameters, cells: of them.
StaticProblem bent_wall(double size_x, int cells, double poisson,
                        const std::function<Vec3(const Vec3&)>& place) {
  StaticProblem problem(quadratic(structured_block({size_x, kWall, kWall}, {cells, 1, 1}), place),
                        make_material({"neo-hookean", {1, poisson}}, "test"));
  problem.prescribe(anywhere, 1);
  return problem;
}

struct BentWall {
  double poisson;
  int cells;  // edges are 2.5 or 1.25 thicknesses
  double allowed;
};
constexpr BentWall kBentWalls[] = {
    {0.3, 1, 0.035}, {0.45, 1, 0.02}, {0.45, 2, 0.036}, {0.49, 1, 0.034}};

// Timoshenko's beam in plane strain, clamped at one end, under a transverse force at the other.
TEST(Elasticity, a_plate_of_one_element_bends_as_the_closed_form) {
  constexpr double kLength = 60, kTraction = 1e-8;
  for (const auto& [poisson, cells, allowed] : kBentWalls) {
    StaticProblem problem = bent_wall(kLength, 8 * cells, poisson, same);
    for (const int axis : {0, 2}) problem.prescribe(in_plane(0, 0), axis);
    problem.add_traction(in_plane(0, kLength), kTraction * Vec3::UnitZ());
    const StaticOutcome out = solve(problem, 1);
    ASSERT_TRUE(out.is_solved);
    const double plane = 1 / (1 - poisson * poisson), shear = 1 / (2 + 2 * poisson);
    const double expected =
        kTraction * kWall *
        (4 * std::pow(kLength / kWall, 3) / plane + 1.2 * kLength / (shear * kWall));
    char id[64];
    std::snprintf(id, sizeof id, "FE/plate_bent nu%g", poisson);
    const double error =
        report(id, std::to_string(8 * cells), expected,
               out.u(node_at(problem.mesh, {kLength, 0, kWall / 2}), 2), "", out.cpu_s);
    EXPECT_LE(std::abs(error), allowed) << id;
  }
}

// A quarter of a ring under two opposite forces (Roark's Formulas for Stress and Strain, 8th
// edition, table 9.2, case 1).
TEST(Elasticity, a_cylinder_of_one_element_is_pinched_as_the_closed_form) {
  constexpr double kRadius = 35, kTraction = 1e-8;
  for (const auto& [poisson, cells, allowed] : kBentWalls) {
    StaticProblem problem = bent_wall(kPi / 2, 7 * cells, poisson, [](const Vec3& p) {
      const double r = kRadius + p.z() - kWall / 2;
      return Vec3(r * std::sin(p.x()), p.y(), r * std::cos(p.x()));
    });
    problem.prescribe(in_plane(0, 0), 0), problem.prescribe(in_plane(2, 0), 2);
    problem.add_traction(in_plane(0, 0), -kTraction * Vec3::UnitZ());
    const StaticOutcome out = solve(problem, 1);
    ASSERT_TRUE(out.is_solved);
    const double plane = 1 / (1 - poisson * poisson), thin = std::pow(kWall / kRadius, 2) / 12,
                 k1 = 1 - thin + 1.2 * plane * (2 + 2 * poisson) * thin, k2 = 1 - thin;
    const double expected = -kTraction * kWall * 12 / plane * std::pow(kRadius / kWall, 3) *
                            (kPi * k1 / 4 - 2 * k2 * k2 / kPi);
    char id[64];
    std::snprintf(id, sizeof id, "FE/cylinder_pinched nu%g", poisson);
    const double error = report(id, std::to_string(7 * cells), expected,
                                out.u(node_at(problem.mesh, {0, 0, kRadius}), 2), "", out.cpu_s);
    EXPECT_LE(std::abs(error), allowed) << id;
  }
}

}  // namespace
}  // namespace palpate::fem
