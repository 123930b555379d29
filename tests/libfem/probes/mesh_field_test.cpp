#include "libfem/probes/mesh_field.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "probe_cases.hpp"

namespace palpate::fem {
namespace {

const double kAutomatic = std::numeric_limits<double>::quiet_NaN();

double box_distance(const Vec3& half, const Vec3& x) {
  const Vec3 q = x.cwiseAbs() - half;
  return q.cwiseMax(0).norm() + std::min(q.maxCoeff(), 0.0);
}

TEST(MeshField, exact_distance_to_a_box_is_the_closed_form_inside_and_out) {
  const Vec3 half(0.004, 0.006, 0.01);
  const MeshField field(box_mesh(half), kAutomatic, "t");
  std::mt19937 random(11);
  std::uniform_real_distribution<double> spread(-0.015, 0.015);
  for (int i = 0; i < 5000; ++i) {
    const Vec3 x(spread(random), spread(random), spread(random));
    const SignedDistance here = field.exact(x);
    EXPECT_NEAR(here.distance_m, box_distance(half, x), 1e-16) << "seed 11, place " << i;
    EXPECT_NEAR(here.gradient.norm(), 1, 1e-12);
  }
  // On a face, an edge, a corner, where sign and direction come from the pseudonormal.
  for (const Vec3& x : {Vec3(0.004, 0.001, 0), Vec3(0.004, 0.006, 0), Vec3(0.004, 0.006, 0.01)})
    EXPECT_NEAR(field.exact(x).gradient.norm(), 1, 1e-12);
}

TEST(MeshField, exact_derivatives_are_differences_on_the_pieces_of_the_field) {
  const MeshField field(box_mesh(Vec3(0.004, 0.006, 0.01)), kAutomatic, "t");
  for (const Vec3& x :
       {Vec3(0.005, 0.001, 0.002), Vec3(0.005, 0.008, 0.003), Vec3(0.005, 0.008, 0.014)}) {
    const SignedDistance here = field.exact(x);
    for (int c = 0; c < 3; ++c) {
      const Vec3 d = 1e-7 * Vec3::Unit(c);
      const SignedDistance up = field.exact(x + d), down = field.exact(x - d);
      EXPECT_NEAR((up.distance_m - down.distance_m) / 2e-7, here.gradient[c], 1e-6);
      EXPECT_LE(((up.gradient - down.gradient) / 2e-7 - here.hessian.col(c)).norm(), 1e-3);
    }
  }
}

TEST(MeshField, smoothing_leaves_flat_and_round_parts_in_place_and_rounds_edges) {
  const Vec3 half(0.004, 0.006, 0.01);
  const MeshField box(box_mesh(half), 0.0004, "t");
  EXPECT_NEAR(box.smooth(Vec3(0.001, 0.002, 0.01)).distance_m, 0, 1e-12);
  EXPECT_NEAR(box.smooth(Vec3(0.001, 0.002, 0.0095)).distance_m, -0.0005, 1e-12);
  EXPECT_LE((box.smooth(Vec3(0.001, 0.002, 0.0099)).gradient - Vec3::UnitZ()).norm(), 1e-12);
  const SignedDistance edge = box.smooth(Vec3(0.004, 0.001, 0.01));
  EXPECT_GT(edge.distance_m, 0);       // the smoothed edge lies inside the sharp one
  EXPECT_LT(edge.distance_m, 0.0002);  // by less than half a spacing
  EXPECT_LT(edge.hessian.norm(), 2 / 0.0004);
  EXPECT_GT(edge.hessian.norm(), 0.2 / 0.0004);

  const MeshField ball(ball_mesh(0.008, 5), 0.0005, "t");
  std::mt19937 random(12);
  for (int i = 0; i < 500; ++i) {
    const Vec3 unit = random_unit(random);
    const SignedDistance here = ball.smooth(0.008 * unit);
    EXPECT_NEAR(here.distance_m, 0, 1e-5);  // the facets lie 6 um inside
    EXPECT_LE((here.gradient - unit).norm(), 0.02);
  }
}

TEST(MeshField, smoothed_distance_has_two_continuous_derivatives_across_an_edges_bisector) {
  const MeshField box(box_mesh(Vec3(0.004, 0.006, 0.01)), 0.0004, "t");
  for (const double inside : {0.0, 0.0001, 0.0005}) {
    const Vec3 x(0.004 - inside, 0.001, 0.01 - inside), across(1e-9, 0, -1e-9);
    const SignedDistance a = box.smooth(x - across), b = box.smooth(x + across);
    EXPECT_LE((a.gradient - b.gradient).norm(), 1e-4);
    EXPECT_LE((a.hessian - b.hessian).norm(), 1e-3 * a.hessian.norm());
  }
}

TEST(MeshField, an_orientation_turns_a_box_as_it_says) {
  ProbeSpec spec;
  spec.shape = "mesh";
  spec.mesh = box_mesh(Vec3(0.004, 0.006, 0.01));
  const Probe down = make_probe(spec, "t");  // own x along x, for own -z points into the body
  EXPECT_NEAR(down.distance(Vec3::UnitZ(), Vec3(0.005, 0, -0.01)).distance_m, 0.001, 1e-9);
  EXPECT_NEAR(down.distance(Vec3::UnitZ(), Vec3(0, 0.007, -0.01)).distance_m, 0.001, 1e-9);
  spec.orientation = Vec3::UnitX();  // its side: own z leans along x
  const Probe side = make_probe(spec, "t");
  EXPECT_NEAR(side.distance(Vec3::UnitZ(), Vec3(0.011, 0, -0.004)).distance_m, 0.001, 1e-9);
  EXPECT_NEAR(side.distance(Vec3::UnitZ(), Vec3(0, 0.007, -0.004)).distance_m, 0.001, 1e-9);
}

}  // namespace
}  // namespace palpate::fem
