#include "libfem/mesh/grade/grade_mesh.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <thread>

#include "data/generators/structured_block.hpp"
#include "libfem/mesh/grade/grade_steps.hpp"
#include "libfem/mesh/topology.hpp"
#include "tests/libfem/mesh/grade/bodies_for_tests.hpp"
#include "tests/libfem/mesh/grade/measures.hpp"
#include "tests/support/error_of.hpp"

namespace palpate::fem {
namespace {

const Vec3 kTop{0.05, 0.05, 0.04};
const GradeOptions kPress{.path = {{kTop, kTop}}};

std::vector<char> held_below(const TetMesh& mesh, double z_m) {
  std::vector<char> held(static_cast<std::size_t>(mesh.nodes.rows()));
  for (Eigen::Index n = 0; n < mesh.nodes.rows(); ++n) held[n] = mesh.nodes(n, 2) <= z_m;
  return held;
}

double min_dihedral_deg(const QuadraticMesh& mesh) {
  return quality_of({mesh.nodes, mesh.tets.leftCols<4>(), {}}).min_dihedral_deg;
}

// Largest distance of a boundary node to the sphere about the origin, relative to its radius.
double sphere_error(const QuadraticMesh& mesh, double radius_m) {
  double worst = 0;
  for (Eigen::Index i = 0; i < mesh.faces.size(); ++i)
    worst = std::max(worst, std::abs(mesh.nodes.row(mesh.faces.data()[i]).norm() - radius_m));
  return worst / radius_m;
}

struct Block {
  TetMesh base = structured_block({0.1, 0.1, 0.04}, {5, 5, 2});
  std::vector<char> held = held_below(base, 0);
  SmoothSurface surface{boundary_surface(base)};
};

TEST(GradeMesh, neighbours_share_all_six_nodes_of_a_face) {
  const Block block;
  const QuadraticMesh mesh = grade_mesh(block.base, block.held, block.surface, kPress);
  std::map<std::set<std::int32_t>, int> tets_with;
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t)
    for (int f = 0; f < 4; ++f) {
      std::set<std::int32_t> nodes;
      for (const int corner : kTetFace[f]) nodes.insert(mesh.tets(t, corner));
      for (int e = 0; e < 6; ++e)
        if (kTetEdge[e][0] != f && kTetEdge[e][1] != f) nodes.insert(mesh.tets(t, 4 + e));
      ASSERT_EQ(nodes.size(), 6u);
      ++tets_with[nodes];
    }
  std::size_t single = 0;
  for (const auto& [nodes, count] : tets_with) {
    ASSERT_LE(count, 2);
    single += count == 1;
  }
  EXPECT_EQ(single, static_cast<std::size_t>(mesh.faces.rows()));
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f) {
    std::set<std::int32_t> nodes;
    for (int k = 0; k < 6; ++k) nodes.insert(mesh.faces(f, k));
    EXPECT_EQ(tets_with.at(nodes), 1) << "face " << f;
  }
  std::set<std::int32_t> used;
  for (Eigen::Index i = 0; i < mesh.tets.size(); ++i) used.insert(mesh.tets.data()[i]);
  EXPECT_EQ(used.size(), static_cast<std::size_t>(mesh.nodes.rows())) << "a node without a tet";
}

TEST(GradeMesh, faces_point_outward_with_mid_edge_nodes_in_order) {
  const Block block;
  const QuadraticMesh mesh = grade_mesh(block.base, block.held, block.surface, kPress);
  EXPECT_NEAR(volume_m3(Surface{mesh.nodes, mesh.faces.leftCols<3>()}), 4e-4, 4e-16);
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const Vec3 middle =
          0.5 * (mesh.nodes.row(mesh.faces(f, k)) + mesh.nodes.row(mesh.faces(f, (k + 1) % 3)));
      EXPECT_LT((mesh.nodes.row(mesh.faces(f, 3 + k)).transpose() - middle).norm(), 1e-15);
    }
}

TEST(GradeMesh, block_keeps_its_volume_its_edges_and_its_angles) {
  const Block block;
  GradeOptions options = kPress;
  options.path[0].h_m = 0.004;
  const QuadraticMesh mesh = grade_mesh(block.base, block.held, block.surface, options);
  EXPECT_NEAR(quadratic_volume_m3(mesh), 4e-4, 4e-16);
  EXPECT_LT(mesh.deviation_m, 1e-15);
  EXPECT_GT(min_dihedral_deg(mesh), 40);
  EXPECT_GT(mesh.nodes.rows(), 3000);
  EXPECT_LT(mesh.nodes.rows(), 9000);
  for (Eigen::Index n = 0; n < mesh.nodes.rows(); ++n) {
    const Vec3 x = mesh.nodes.row(n);
    const Eigen::Array3d below = x.array(), above = Eigen::Array3d(0.1, 0.1, 0.04) - x.array();
    EXPECT_GT(below.min(above).minCoeff(), -1e-15) << "node " << n << " at " << x.transpose();
  }
}

TEST(GradeMesh, held_is_the_bottom_with_its_new_nodes_and_nothing_else) {
  const Block block;
  GradeOptions at_bottom_edge = kPress;  // refines the bottom, and the sides just above it
  at_bottom_edge.path = {{{0.05, 0, 0}, {0.05, 0, 0}}};
  const QuadraticMesh mesh = grade_mesh(block.base, block.held, block.surface, at_bottom_edge);
  int held = 0;
  for (Eigen::Index n = 0; n < mesh.nodes.rows(); ++n) {
    EXPECT_EQ(mesh.is_held[n] != 0, std::abs(mesh.nodes(n, 2)) < 1e-12) << "node " << n;
    held += mesh.is_held[n];
  }
  EXPECT_GT(held, 200);
}

TEST(GradeMesh, tets_held_at_every_corner_are_held_throughout) {
  const Block block;
  const std::vector<char> held = held_below(block.base, 0.0201);
  GradeOptions at_corner = kPress;
  at_corner.path = {{{0, 0, 0.01}, {0, 0, 0.01}}};
  const QuadraticMesh mesh = grade_mesh(block.base, held, block.surface, at_corner);
  for (Eigen::Index n = 0; n < mesh.nodes.rows(); ++n)
    EXPECT_EQ(mesh.is_held[n] != 0, mesh.nodes(n, 2) < 0.0200001) << mesh.nodes.row(n);
}

// Elements that the border of what is held went through made a spindle between two clamps 2 % too
// soft.
TEST(GradeMesh, what_is_held_ends_at_elements_where_no_base_face_ends_there) {
  const Block block;  // base layers of 20 mm
  constexpr double kHeight_m = 0.0113;
  GradeOptions at_side = kPress;
  at_side.path = {{{0, 0.05, 0.01}, {0, 0.05, 0.01}}};
  at_side.held_at = [](const Vec3& x, bool) { return x.z() < kHeight_m; };
  const QuadraticMesh mesh = grade_mesh(block.base, block.held, block.surface, at_side);
  int on_border = 0;
  for (Eigen::Index n = 0; n < mesh.nodes.rows(); ++n) {
    EXPECT_EQ(mesh.is_held[n] != 0, mesh.nodes(n, 2) < kHeight_m + 1e-9) << mesh.nodes.row(n);
    on_border += std::abs(mesh.nodes(n, 2) - kHeight_m) < 1e-9;
  }
  EXPECT_GT(on_border, 50);
  int cut = 0;
  for (const auto& tet : mesh.tets.rowwise()) {
    bool is_below = false, is_above = false;
    for (int k = 0; k < 4; ++k) {
      is_below |= mesh.nodes(tet[k], 2) < kHeight_m - 1e-9;
      is_above |= mesh.nodes(tet[k], 2) > kHeight_m + 1e-9;
    }
    cut += is_below && is_above;
  }
  EXPECT_LT(cut, 0.05 * mesh.tets.rows());
}

TEST(GradeMesh, regions_are_inherited) {
  Block block;
  block.base.region.resize(block.base.tets.rows());
  for (Eigen::Index t = 0; t < block.base.tets.rows(); ++t)
    block.base.region[t] = centroid(block.base, t).x() > 0.06;
  const QuadraticMesh mesh = grade_mesh(block.base, block.held, block.surface, kPress);
  ASSERT_EQ(mesh.region.size(), mesh.tets.rows());
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t)
    EXPECT_EQ(mesh.region[t], centroid(mesh, t).x() > 0.06);
}

TEST(GradeMesh, coarse_ball_becomes_the_fine_sphere_as_the_mesh_is_refined) {
  const double radius = 0.05, exact = 4 * 3.14159265358979323846 / 3 * std::pow(radius, 3);
  const TetMesh base = tet_ball(radius, 1);
  const SmoothSurface surface(icosphere(5, radius));  // 1.7 mm edges
  double before = 1;
  for (const double h : {0.02, 0.01, 0.005}) {
    GradeOptions everywhere{.path = {{Vec3::Zero(), Vec3::Zero(), h, 1}}};
    const QuadraticMesh mesh = grade_mesh(base, held_nowhere(base), surface, everywhere);
    const double error = std::abs(quadratic_volume_m3(mesh) / exact - 1);
    double least = 1;
    for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t)
      least = std::min(least, smallest_jacobian(nodes_of(mesh, t)));
    EXPECT_GT(least, 0);
    EXPECT_LT(mesh.deviation_m, 1e-9);
    EXPECT_LT(sphere_error(mesh, radius), 1e-5);
    EXPECT_LT(error, before / 4);
    before = error;
  }
  EXPECT_LT(before, 1e-5);
}

TEST(GradeMesh, cylinder_becomes_round_and_its_rim_stays_a_rim) {
  const double radius = 0.03, length = 0.1, sagitta = radius * (1 - std::cos(3.14159265 / 48));
  const TetMesh base = star(cylinder(radius, length, 12, 5), {0, 0, length / 2});
  const SmoothSurface surface(cylinder(radius, length, 48, 20));
  const QuadraticMesh mesh =
      grade_mesh(base, held_nowhere(base), surface,
                 {.path = {{{radius, 0, length}, {radius, 0, length}, 0.005}}});
  int on_rim = 0;
  for (Eigen::Index i = 0; i < mesh.faces.size(); ++i) {
    const Vec3 x = mesh.nodes.row(mesh.faces.data()[i]);
    const double off_side = radius - x.head<2>().norm();
    const double off_cap = std::min(std::abs(x.z()), std::abs(x.z() - length));
    EXPECT_GT(off_side, -0.02 * sagitta) << x.transpose();
    EXPECT_TRUE(off_cap < 1e-15 || off_side < 0.02 * sagitta) << x.transpose();
    // The rim itself is the fine surface's polygon, which is off the circle by its sagitta.
    on_rim += off_cap < 1e-15 && off_side < 1.01 * sagitta;
  }
  EXPECT_GT(on_rim, 60);
  EXPECT_LT(mesh.deviation_m, 1e-9);
}

TEST(GradeMesh, base_nodes_off_the_surface_are_moved_onto_it) {
  const double radius = 0.05;
  TetMesh base = tet_ball(radius, 1);
  for (Eigen::Index n = 1; n < base.nodes.rows(); ++n)
    base.nodes.row(n) *= n % 2 ? 1.02 : 0.98;  // a millimetre in or out, as remeshing leaves them
  const SmoothSurface surface(icosphere(4, radius));
  const QuadraticMesh mesh =
      grade_mesh(base, held_nowhere(base), surface, {.path = {{{0, 0, radius}, {0, 0, radius}}}});
  EXPECT_LT(sphere_error(mesh, radius), 1e-4);
  EXPECT_LT(mesh.deviation_m, 1e-9);
}

TEST(GradeMesh, a_move_that_would_spoil_an_element_is_cut_and_told) {
  // A slab 2 mm thick whose surface lies 1.9 mm lower: going there would flatten its tets.
  const TetMesh base = structured_block({0.04, 0.04, 0.002}, {4, 4, 1});
  Surface low = boundary_surface(base);
  for (Eigen::Index v = 0; v < low.vertices.rows(); ++v)
    if (low.vertices(v, 2) > 0.001) low.vertices(v, 2) = 0.0001;
  const SmoothSurface surface(low);
  GradeOptions options{.path = {{{0.02, 0.02, 0.002}, {0.02, 0.02, 0.002}, 0.01}}};
  const QuadraticMesh mesh = grade_mesh(base, held_nowhere(base), surface, options);
  EXPECT_GT(mesh.deviation_m, 0.0003);
  // The whole slab is near: half of its nodes are on its sides or bottom, where they belong.
  EXPECT_GT(mesh.contact_deviation_m, mesh.deviation_m / 4);
  EXPECT_LT(mesh.contact_deviation_m, mesh.deviation_m);
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t)
    EXPECT_GT(smallest_jacobian(nodes_of(mesh, t)), 0) << "tet " << t;
}

TEST(GradeMesh, a_fine_mesh_under_a_base_face_that_is_far_off_lies_on_the_surface) {
  // A bowl, 5 mm deep, in a block whose base has its corners and a node 4 mm under its top.
  constexpr double kSide_m = 0.1, kHeight_m = 0.04, kDip_m = 0.005;
  TetMesh bowl = structured_block({kSide_m, kSide_m, kHeight_m}, {40, 40, 4});
  for (auto node : bowl.nodes.rowwise()) {
    const double x = 2 * node[0] / kSide_m - 1, y = 2 * node[1] / kSide_m - 1;
    node[2] *= 1 - kDip_m / kHeight_m * (1 - x * x) * (1 - y * y);
  }
  const TetMesh base =
      star(boundary_surface(structured_block({kSide_m, kSide_m, kHeight_m}, {1, 1, 1})),
           {kSide_m / 2, kSide_m / 2, kHeight_m - 0.004});
  const Vec3 lowest{kSide_m / 2, kSide_m / 2, kHeight_m - kDip_m};
  const GradeOptions press{.path = {{lowest, lowest, 1e-3, 8e-3}}};
  const QuadraticMesh mesh =
      grade_mesh(base, held_below(base, 0), SmoothSurface(boundary_surface(bowl)), press);
  EXPECT_LT(mesh.contact_deviation_m, 0.05e-3);
  double nearest_m = 1;
  for (const std::int32_t n : mesh.faces.reshaped())
    nearest_m = std::min(nearest_m, (mesh.nodes.row(n).transpose() - lowest).norm());
  EXPECT_LT(nearest_m, 1e-3);
}

TEST(GradeMesh, path_of_a_drag_is_fine_along_its_whole_length) {
  const Block block;
  GradeOptions options = kPress;
  options.path = {{{0.05, 0.05, 0.04}, {0.075, 0.05, 0.04}},
                  {{0.05, 0.05, 0.04}, {0.05, 0.07, 0.04}}};
  const QuadraticMesh mesh = grade_mesh(block.base, block.held, block.surface, options);
  GradeOptions inner = options;  // a tet counts by its centroid: stay a size inside the zone
  const double h_m = options.path[0].h_m;
  for (Segment& piece : inner.path) piece.reach_m -= h_m;
  const double largest = h_m * std::sqrt(3.0);  // by the definition of size
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f) {
    const Vec3 a = mesh.nodes.row(mesh.faces(f, 0)), b = mesh.nodes.row(mesh.faces(f, 1));
    if (wanted_size_m(inner, 0.5 * (a + b)) <= h_m) {
      EXPECT_LT((a - b).norm(), largest) << "face " << f;
    }
  }
}

TEST(GradeMesh, each_piece_of_the_path_has_its_own_size_and_the_finest_wish_wins) {
  const Vec3 end = kTop + Vec3(0.02, 0, 0);
  const GradeOptions options{.path = {{kTop, kTop, 0.001, 0}, {kTop, end, 0.004, 0.002}},
                             .growth = 0.5};
  EXPECT_NEAR(wanted_size_m(options, kTop), 0.001, 1e-15);
  EXPECT_NEAR(wanted_size_m(options, kTop - Vec3(0, 0, 0.004)), 0.002, 1e-15);  // 0.5 * 4 mm
  EXPECT_NEAR(wanted_size_m(options, end), 0.004, 1e-15);
  EXPECT_NEAR(wanted_size_m(options, end + Vec3(0.012, 0, 0)), 0.005, 1e-15);  // 0.5 * (12 - 2) mm
}

// Shells of doubling radius about the point of first touch hold about as many tets each: a press is
// resolved alike at every depth, for a number of nodes that grows with the logarithm of its range.
TEST(GradeMesh, size_proportional_to_distance_gives_every_octave_as_many_tets) {
  const Block block;
  const GradeOptions options{.path = {{kTop, kTop, 0.0005, 0}}, .growth = 0.4};
  const QuadraticMesh mesh = grade_mesh(block.base, block.held, block.surface, options);
  int in_shell[3] = {};
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t) {
    const double octave = std::log2((centroid(mesh, t) - kTop).norm() / 0.0025);
    if (octave >= 0 && octave < 3) ++in_shell[static_cast<int>(octave)];
  }
  for (const int tets : in_shell) {
    EXPECT_GT(tets, 0.6 * in_shell[1]);
    EXPECT_LT(tets, 1.6 * in_shell[1]);
  }
}

TEST(GradeMesh, result_is_the_same_bit_for_bit_on_any_thread) {
  const TetMesh base = tet_ball(0.05, 1);
  const std::vector<char> held = held_nowhere(base);
  const SmoothSurface surface(icosphere(4, 0.05));
  const GradeOptions options{.path = {{{0, 0, 0.05}, {0, 0, 0.05}}}};
  const QuadraticMesh first = grade_mesh(base, held, surface, options);
  std::vector<QuadraticMesh> others(4);
  std::vector<std::thread> threads;
  for (QuadraticMesh& other : others)
    threads.emplace_back([&] { other = grade_mesh(base, held, surface, options); });
  for (std::thread& thread : threads) thread.join();
  for (const QuadraticMesh& other : others) {
    EXPECT_EQ(first.nodes, other.nodes);
    EXPECT_EQ(first.tets, other.tets);
    EXPECT_EQ(first.faces, other.faces);
  }
}

TEST(GradeMesh, a_tet_inside_out_is_refused) {
  const Block block;
  TetMesh inside_out = block.base;
  std::swap(inside_out.tets(7, 0), inside_out.tets(7, 1));
  EXPECT_THROW(grade_mesh(inside_out, block.held, block.surface, kPress), Error);
}

}  // namespace
}  // namespace palpate::fem
