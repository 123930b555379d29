// Closed loops of the paper's kind over its cylinder, without the guard: what they create is in
// closed form. Each loop presses in one place, slides and lets go in another; friction, were it
// there, would have to pay.

#include <gtest/gtest.h>

#include <cstdio>

#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {
namespace {

constexpr double kRadius_m = 0.03, kNone = 1e-7;  // friction of the model as it is published: none

/// The paper's cylinder, R 30 mm, even: f^z = 300 N/m d, so that ring 1 is the whole bed.
Model even_cylinder(int around, double friction) {
  constexpr double kRange_m = 0.0025;
  Model model;
  model.surface = cylinder_surface(around);
  const Eigen::Index vertices = model.surface.vertices.rows();
  model.inward_normal = Points::Zero(vertices, 3);
  model.inward_normal.leftCols(2) = -model.surface.vertices.leftCols(2).rowwise().normalized();
  model.is_covered.assign(static_cast<std::size_t>(vertices), 1);
  make_rings(model, 1, 0, even);
  model.curves.basis[0] = {1, {0, kRange_m}};
  model.curves.control[0] = Controls::Zero(vertices, 2);
  for (Eigen::Index v = 0; v < vertices; ++v) {
    const Vec3 u = model.inward_normal.row(v), axis(0, 0, 1), tangent = u.cross(axis);
    model.curves.control[0](v, 1) = 300 * kRange_m;
    model.curves.control[runtime::kFriction](v, 0) = friction;
    model.curves.control[runtime::kFrictionSlope](v, 0) = 0;
    model.curves.control[runtime::kCurvature].row(v) =
        numbers_of(tangent * tangent.transpose() / 0.03);
  }
  return model;
}

/// Energy that a tool created from touch to lift-off over these places, in steps of 1 um [J].
double created_J(const runtime::AssetView& asset, const std::vector<Vec3>& way, long* slips) {
  runtime::AssetView bare = asset;
  bare.has_guard = false;
  Contact contact;
  Output out;
  for (std::size_t i = 1; i < way.size(); ++i) {
    const int steps = static_cast<int>((way[i] - way[i - 1]).norm() / 1e-6) + 1;
    for (int k = 1; k <= steps; ++k) {
      const Vec3 x = way[i - 1] + (way[i] - way[i - 1]) * (double(k) / steps);
      EXPECT_EQ(touch(bare, contact, x.data(), out), Status::ok);
      *slips += out.state == ContactState::slip;
    }
  }
  EXPECT_EQ(out.state, ContactState::air);
  return -out.dissipated_J;
}

Vec3 at(double radius_m, double angle, double z_m) {
  return {radius_m * std::cos(angle), radius_m * std::sin(angle), z_m};
}
/// Down where the cylinder's facet is middle, round to its edge, and out; angles in facets.
std::vector<Vec3> round_a_facet(int around, double from, double deep_m) {
  const double facet = 2 * std::numbers::pi / around, z_m = 0.0443, inner_m = kRadius_m - deep_m;
  std::vector<Vec3> out{at(0.031, from * facet, z_m)};
  for (int i = 0; i <= 40; ++i)
    out.push_back(at(inner_m, (from + (1 - from) * i / 40) * facet, z_m));
  out.push_back(at(0.031, facet, z_m));
  return out;
}
/// The same along a facet's middle line.
std::vector<Vec3> along(int around, double from_m, double to_m, double deep_m) {
  const double angle = std::numbers::pi / around, facet_m = kRadius_m * std::cos(angle);
  return {at(0.031, angle, from_m), at(facet_m - deep_m, angle, from_m),
          at(facet_m - deep_m, angle, to_m), at(0.031, angle, to_m)};
}

/// f^z = k(z) d^2 / 10 mm on the paper's cylinder.
Model parabolic_cylinder(int around, double friction, const std::function<double(double)>& k_N_m) {
  constexpr double kRange_m = 0.006;
  Model model = even_cylinder(around, friction);
  model.curves.basis[0] = {2, {0, kRange_m}};
  model.curves.control[0] = Controls::Zero(model.surface.vertices.rows(), 3);
  for (Eigen::Index v = 0; v < model.surface.vertices.rows(); ++v)
    model.curves.control[0](v, 2) =
        k_N_m(model.surface.vertices(v, 2)) * kRange_m * kRange_m / 0.01;
  return model;
}
/// 280 N/m below z = 40 mm, 420 above 50.
double soft_then_stiff(double z_m) { return z_m < 0.045 ? 280 : 420; }

/// What a loop creates and the loop backwards takes, half of the sum. A tick of any length slips
/// after its motion and so loses half of lambda k dx^2, the same both ways.
double leak_J(const runtime::AssetView& asset, std::vector<Vec3> way) {
  long slips = 0;
  const double there_J = created_J(asset, way, &slips);
  std::reverse(way.begin(), way.end());
  const double back_J = created_J(asset, way, &slips);
  EXPECT_GT(slips, 1000);
  EXPECT_GT(there_J, 0);
  EXPECT_NEAR(there_J, -back_J, 0.15 * there_J);
  return 0.5 * (there_J - back_J);
}

// The normal turns and the facet does not: at a constant distance from the axis the contact is
// deeper at a facet's edge than in its middle, by R (1 - cos(pi / n)), and no force was met.
TEST(loops, round_a_facet_create_the_difference_of_depth) {
  for (const int around : {25, 50, 100}) {
    const Loaded body = load(even_cylinder(around, kNone));
    constexpr double kDeep_m = 0.0024;  // at the edge
    const double middle_m = kDeep_m - kRadius_m * (1 - std::cos(std::numbers::pi / around));
    const double expected_J = 150 * (kDeep_m * kDeep_m - middle_m * middle_m);
    const double found_J = leak_J(body.asset, round_a_facet(around, 0.5, kDeep_m));
    EXPECT_NEAR(found_J, expected_J, 1e-3 * expected_J) << around;
    std::printf("geometry, %3d facets: %.4f mJ created, %.4f in closed form\n", around,
                1e3 * found_J, 1e3 * expected_J);
  }
}

// What is pressed in where the body is soft comes out where it is stiff.
TEST(loops, from_soft_to_stiff_create_the_difference_of_the_stored_energies) {
  constexpr int kAround = 100;
  const Loaded body = load(parabolic_cylinder(kAround, kNone, soft_then_stiff));
  constexpr double kDeep_m = 0.004;
  const auto stored_J = [](double k_N_m) { return k_N_m * std::pow(kDeep_m, 3) / 0.03; };
  const double expected_J = stored_J(420) - stored_J(280);  // 2.98667e-4 J
  EXPECT_NEAR(expected_J, 2.98667e-4, 1e-9);
  const double found_J = leak_J(body.asset, along(kAround, 0.0357, 0.0543, kDeep_m));
  EXPECT_NEAR(found_J, expected_J, 1e-3 * expected_J);
  std::printf("stiffness gradient: %.4f mJ created, %.4f in closed form\n", 1e3 * found_J,
              1e3 * expected_J);
}

}  // namespace
}  // namespace palpate::test
