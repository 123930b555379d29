#include "libfem/mesh/grade/grade_steps.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "data/generators/structured_block.hpp"
#include "libfem/mesh/grade/grade_mesh.hpp"
#include "libfem/mesh/topology.hpp"
#include "tests/libfem/mesh/grade/bodies_for_tests.hpp"
#include "tests/libfem/mesh/grade/measures.hpp"

namespace palpate::fem {
namespace {

/// A block of 100 x 100 x 40 mm, pressed in the middle of its top, and what fills it.
QuadraticMesh pressed_block(const RegionAt& region_at, double interface_size_m = INFINITY) {
  const TetMesh base = structured_block({0.1, 0.1, 0.04}, {5, 5, 2});
  GradeOptions options{.path = {{{0.05, 0.05, 0.04}, {0.05, 0.05, 0.04}}}};
  options.region_at = region_at;
  options.interface_share = 0.5;
  options.interface_size_m = interface_size_m;
  return grade_mesh(base, held_nowhere(base), SmoothSurface(boundary_surface(base)), options);
}

/// Signed distances of a tet's corners to a border: all of one sign, but for rounding.
template <class Distance>
int tets_across(const QuadraticMesh& mesh, const Distance& distance_m) {
  int across = 0;
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t) {
    double least = INFINITY, most = -INFINITY;
    for (int k = 0; k < 4; ++k) {
      const double d = distance_m(Vec3(mesh.nodes.row(mesh.tets(t, k))));
      least = std::min(least, d);
      most = std::max(most, d);
    }
    across += least < -1e-9 && most > 1e-9;
  }
  return across;
}

QuadraticMesh part_of(const QuadraticMesh& mesh, const RegionAt& region_at, int region) {
  QuadraticMesh out = mesh;
  Eigen::Index count = 0;
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t)
    if (region_at(centroid(mesh, t)) == region) out.tets.row(count++) = mesh.tets.row(t);
  out.tets.conservativeResize(count, 10);
  return out;
}

const Vec3 kBall{0.052, 0.047, 0.026};
constexpr double kBallRadius_m = 0.008;
int in_ball(const Vec3& x) { return (x - kBall).norm() < kBallRadius_m; }

TEST(Conform, no_tet_is_on_both_sides_of_a_ball_and_the_ball_keeps_its_volume) {
  const QuadraticMesh mesh = pressed_block(in_ball);
  EXPECT_EQ(tets_across(mesh, [](const Vec3& x) { return (x - kBall).norm() - kBallRadius_m; }), 0);
  const double ball = 4.0 / 3 * std::numbers::pi * std::pow(kBallRadius_m, 3);
  EXPECT_NEAR(quadratic_volume_m3(part_of(mesh, in_ball, 1)) / ball, 1, 0.02);
  EXPECT_NEAR(quadratic_volume_m3(mesh), 4e-4, 1e-15);
}

TEST(Conform, a_layer_that_reaches_the_sides_is_cut_exactly) {
  const RegionAt layer = [](const Vec3& x) { return x.z() > 0.0313; };
  const QuadraticMesh mesh = pressed_block(layer);
  EXPECT_EQ(tets_across(mesh, [](const Vec3& x) { return x.z() - 0.0313; }), 0);
  EXPECT_NEAR(quadratic_volume_m3(part_of(mesh, layer, 1)), 0.1 * 0.1 * 0.0087, 1e-9);
  EXPECT_LT(mesh.deviation_m, 1e-12) << "new nodes of the sides are on them";
}

// A node on one border hid the other one from its edges: a press on skin, fat and muscle was 4.7 %
// too stiff in rows that stated 1.2.
TEST(Conform, two_layers_are_both_cut_where_an_element_reaches_through_them) {
  const RegionAt layers = [](const Vec3& x) { return x.z() > 0.0371 ? 1 : x.z() > 0.0313 ? 2 : 0; };
  const QuadraticMesh mesh = pressed_block(layers);
  for (const double border_m : {0.0313, 0.0371})
    EXPECT_EQ(tets_across(mesh, [&](const Vec3& x) { return x.z() - border_m; }), 0);
  EXPECT_NEAR(quadratic_volume_m3(part_of(mesh, layers, 1)), 0.1 * 0.1 * 0.0029, 1e-8);
  EXPECT_NEAR(quadratic_volume_m3(part_of(mesh, layers, 2)), 0.1 * 0.1 * 0.0058, 1e-8);
}

// Presses on skin, fat and muscle took four times as long as on muscle alone.
TEST(Conform, a_layer_is_cut_near_the_contact_and_left_in_elements_that_are_large) {
  const RegionAt layer = [](const Vec3& x) { return x.z() > 0.0313; };
  const auto off_m = [](const Vec3& x) { return x.z() - 0.0313; };
  const QuadraticMesh near = pressed_block(layer, 0.006);
  EXPECT_GT(tets_across(near, off_m), 0);
  const RegionAt at_contact = [](const Vec3& x) {
    return (x - Vec3(0.05, 0.05, 0.04)).norm() < 0.012;
  };
  const QuadraticMesh middle = part_of(near, at_contact, 1);
  EXPECT_GT(middle.tets.rows(), 20);
  EXPECT_EQ(tets_across(middle, off_m), 0);
}

// Elements of a flat border need not be smaller than others.
TEST(Conform, a_flat_layer_halves_no_element_and_a_ball_does) {
  const auto corners = [](const RegionAt& region_at) {
    const TetMesh base = structured_block({0.1, 0.1, 0.04}, {5, 5, 2});
    GradeOptions options{.path = {{{0.05, 0.05, 0.04}, {0.05, 0.05, 0.04}}}};
    options.region_at = region_at;
    options.interface_share = 0.5;
    return bisect(base, options).nodes.size();
  };
  EXPECT_EQ(corners([](const Vec3& x) { return x.z() > 0.0313; }), corners({}));
  EXPECT_GT(corners(in_ball), corners({}));
}

TEST(Conform, elements_stay_sound_and_neighbours_share_faces) {
  const QuadraticMesh mesh = pressed_block(in_ball);
  std::map<std::set<std::int32_t>, int> tets_with;
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t) {
    EXPECT_GT(smallest_jacobian(nodes_of(mesh, t)), 0) << "tet " << t;
    for (const auto& face : kTetFace)
      ++tets_with[{mesh.tets(t, face[0]), mesh.tets(t, face[1]), mesh.tets(t, face[2])}];
  }
  Eigen::Index single = 0;
  for (const auto& [nodes, count] : tets_with) {
    ASSERT_LE(count, 2);
    single += count == 1;
  }
  EXPECT_EQ(single, mesh.faces.rows());
  const Tets corners = mesh.tets.leftCols<4>();
  EXPECT_GT(quality_of({mesh.nodes, corners, {}}).min_dihedral_deg, 2.9);
}

TEST(Conform, mid_edge_nodes_of_a_curved_border_lie_on_it_where_elements_allow) {
  const QuadraticMesh mesh = pressed_block(in_ball);
  int curved = 0, straight = 0;
  const QuadraticMesh ball = part_of(mesh, in_ball, 1);
  for (Eigen::Index t = 0; t < ball.tets.rows(); ++t)
    for (int k = 0; k < 6; ++k) {
      const auto off = [&](int node) {
        return std::abs((Vec3(mesh.nodes.row(ball.tets(t, node))) - kBall).norm() - kBallRadius_m);
      };
      if (off(kTetEdge[k][0]) > 1e-9 || off(kTetEdge[k][1]) > 1e-9) continue;
      ++(off(4 + k) < 1e-6 ? curved : straight);
    }
  EXPECT_GT(curved, 3 * straight) << curved << " on the border, " << straight << " not";
}

}  // namespace
}  // namespace palpate::fem
