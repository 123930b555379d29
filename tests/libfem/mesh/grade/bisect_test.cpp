#include "libfem/mesh/grade/grade_steps.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <set>

#include "data/generators/structured_block.hpp"
#include "libfem/mesh/topology.hpp"
#include "tests/libfem/mesh/grade/bodies_for_tests.hpp"
#include "tests/libfem/mesh/grade/measures.hpp"
#include "tests/support/error_of.hpp"

namespace palpate::fem {
namespace {

TetMesh straight(const BisectedMesh& mesh) {
  TetMesh out;
  out.nodes.resize(static_cast<Eigen::Index>(mesh.nodes.size()), 3);
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    out.nodes.row(static_cast<Eigen::Index>(n)) = mesh.nodes[n];
  out.tets.resize(static_cast<Eigen::Index>(mesh.tets.size()), 4);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)
    for (int k = 0; k < 4; ++k)
      out.tets(static_cast<Eigen::Index>(t), k) = mesh.tets[t].node[static_cast<std::size_t>(k)];
  return out;
}

double size_of(const TetMesh& mesh, Eigen::Index t) {
  return tet_size_m(mesh.nodes.row(mesh.tets(t, 0)), mesh.nodes.row(mesh.tets(t, 1)),
                    mesh.nodes.row(mesh.tets(t, 2)), mesh.nodes.row(mesh.tets(t, 3)));
}

// A block with its inside nodes shaken, so that no two edges are as long.
TetMesh shaken_block(unsigned seed, double by_m) {
  TetMesh mesh = structured_block({0.1, 0.1, 0.04}, {5, 5, 2});
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shake(-by_m, by_m);
  std::vector<char> is_boundary(static_cast<std::size_t>(mesh.nodes.rows()), 0);
  const Triangles faces = boundary_triangles(mesh.tets);
  for (Eigen::Index i = 0; i < faces.size(); ++i) is_boundary[faces.data()[i]] = 1;
  for (Eigen::Index n = 0; n < mesh.nodes.rows(); ++n)
    if (!is_boundary[n]) mesh.nodes.row(n) += Vec3(shake(random), shake(random), shake(random));
  return mesh;
}

const GradeOptions kPress{.path = {{{0.05, 0.05, 0.04}, {0.05, 0.05, 0.04}}}};

TEST(StructuredBlock, fills_the_box_with_positive_tets_that_meet_face_to_face) {
  for (const auto& cells : {std::array{1, 1, 1}, std::array{3, 2, 4}}) {
    const TetMesh mesh = structured_block({0.3, 0.2, 0.1}, cells);
    EXPECT_NEAR(quality_of(mesh).volume_m3, 0.006, 1e-16);
    EXPECT_GT(quality_of(mesh).min_volume_m3, 0);
    // As many boundary triangles as the box's own grid has: no face inside is left unmatched.
    const int expected = 4 * (cells[0] * cells[1] + cells[1] * cells[2] + cells[2] * cells[0]);
    EXPECT_EQ(boundary_faces(mesh.tets).size(), static_cast<std::size_t>(expected));
    EXPECT_NEAR(volume_m3({mesh.nodes, boundary_triangles(mesh.tets)}), 0.006, 1e-16);
  }
  EXPECT_THROW(structured_block({0.1, 0, 0.1}, {1, 1, 1}), Error);
  EXPECT_THROW(structured_block({0.1, 0.1, 0.1}, {1, 0, 1}), Error);
}

TEST(Bisect, every_inner_face_joins_two_tets_and_no_volume_is_lost) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const TetMesh base = shaken_block(seed, 0.004);
    const BisectedMesh mesh = bisect(base, kPress);
    const TetMesh fine = straight(mesh);
    EXPECT_GT(fine.tets.rows(), base.tets.rows());
    EXPECT_NEAR(quality_of(fine).volume_m3, 4e-4, 4e-16) << "seed " << seed;
    EXPECT_GT(quality_of(fine).min_volume_m3, 0) << "seed " << seed;
    // boundary_faces throws when three tets share a face; a face that hangs would be found as
    // boundary without a base face, or the other way round.
    std::size_t tagged = 0;
    for (const BoundaryFace& face : boundary_faces(fine.tets))
      EXPECT_GE(mesh.tets[face.tet].face[face.face], 0) << "seed " << seed;
    for (const BisectedTet& tet : mesh.tets)
      for (const std::int32_t face : tet.face) tagged += face >= 0;
    EXPECT_EQ(tagged, boundary_faces(fine.tets).size()) << "seed " << seed;
  }
}

TEST(Bisect, size_is_the_edge_of_the_cube_and_flat_tets_do_not_pass_for_small) {
  const TetMesh cube = structured_block({0.003, 0.003, 0.003}, {1, 1, 1});
  for (Eigen::Index t = 0; t < 6; ++t) EXPECT_NEAR(size_of(cube, t), 0.003, 1e-15);
  EXPECT_NEAR(tet_size_m({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.3, 1e-9}), std::sqrt(2.0 / 3),
              1e-12);
}

TEST(Bisect, every_tet_is_as_small_as_asked_and_far_ones_are_left_alone) {
  const TetMesh base = shaken_block(5, 0.004);
  const TetMesh fine = straight(bisect(base, kPress));
  for (Eigen::Index t = 0; t < fine.tets.rows(); ++t) {
    EXPECT_LE(size_of(fine, t), wanted_size_m(kPress, centroid(fine, t)) * (1 + 1e-12))
        << "tet " << t;
  }
  const GradeOptions coarse{.path = {{kPress.path[0].from, kPress.path[0].to, 1}}};
  EXPECT_EQ(bisect(base, coarse).tets.size(), static_cast<std::size_t>(base.tets.rows()));
}

TEST(Bisect, halved_base_tets_have_parts_of_half_their_size_and_others_are_left_alone) {
  const TetMesh base = shaken_block(3, 0.004);
  GradeOptions options;
  options.path = {{Vec3(0, 0, 10), Vec3(0, 0, 10), 1}};  // asks for nothing
  options.halved.assign(static_cast<std::size_t>(base.tets.rows()), 0);
  options.halved[7] = options.halved[20] = 1;
  const BisectedMesh mesh = bisect(base, options);
  const TetMesh parts = straight(mesh);
  std::vector<int> count(options.halved.size(), 0);
  for (Eigen::Index t = 0; t < parts.tets.rows(); ++t) {
    const std::int32_t of = mesh.tets[static_cast<std::size_t>(t)].base;
    ++count[static_cast<std::size_t>(of)];
    const double share = options.halved[static_cast<std::size_t>(of)] != 0 ? 0.5 : 1;
    EXPECT_LE(size_of(parts, t), share * size_of(base, of) * (1 + 1e-12)) << "tet " << of;
  }
  EXPECT_GE(std::min(count[7], count[20]), 8);
  EXPECT_GT(std::count(count.begin(), count.end(), 1), base.tets.rows() / 2);
}

TEST(Bisect, tets_that_two_regions_share_are_smaller_by_the_share_asked_for_where_borders_bend) {
  const TetMesh base = shaken_block(5, 0.004);
  GradeOptions options = kPress;
  options.interface_share = 0.5;
  options.region_at = [](const Vec3& x) { return (x - Vec3(0.05, 0.05, 0.03)).norm() < 0.004; };
  const TetMesh fine = straight(bisect(base, options));
  int shared = 0, smaller = 0;
  for (Eigen::Index t = 0; t < fine.tets.rows(); ++t) {
    std::set<int> regions;
    for (int k = 0; k < 4; ++k) regions.insert(options.region_at(fine.nodes.row(fine.tets(t, k))));
    const double wanted_m = wanted_size_m(options, centroid(fine, t)) * (1 + 1e-12);
    EXPECT_LE(size_of(fine, t), wanted_m) << "tet " << t;
    shared += regions.size() == 2;
    smaller += regions.size() == 2 && size_of(fine, t) <= 0.5 * wanted_m;
  }
  EXPECT_GT(shared, 50);
  EXPECT_GT(smaller, 0.8 * shared) << "of " << shared << "; others are cut at a corner";
}

TEST(Bisect, dihedral_angles_shrink_boundedly) {
  struct Case {
    const char* name;
    TetMesh base;
    GradeOptions options;
    double min_share;
  };
  GradeOptions ball = kPress, deep = kPress;
  ball.path = {{{0, 0, 0.05}, {0, 0, 0.05}}};
  deep.path[0].h_m = 0.001;
  const Case cases[] = {{"block", structured_block({0.1, 0.1, 0.04}, {5, 5, 2}), kPress, 0.99},
                        {"shaken block", shaken_block(6, 0.004), kPress, 0.45},
                        {"shaken block, h 1 mm", shaken_block(6, 0.004), deep, 0.45},
                        {"ball", tet_ball(0.05, 1), ball, 0.35}};
  for (const Case& c : cases) {
    const TetMesh fine = straight(bisect(c.base, c.options));
    const double before = quality_of(c.base).min_dihedral_deg,
                 after = quality_of(fine).min_dihedral_deg;
    EXPECT_GT(after, c.min_share * before) << c.name;
  }
}

TEST(Bisect, refinement_without_end_is_refused) {
  GradeOptions options = kPress;
  options.path[0].h_m = 1e-5;
  options.max_corners = 5000;
  const TetMesh block = structured_block({0.1, 0.1, 0.04}, {5, 5, 2});
  EXPECT_EQ(testing_support::fact_of([&] { bisect(block, options); }),
            "refinement passes 5000 corner nodes");
}

}  // namespace
}  // namespace palpate::fem
