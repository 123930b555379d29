#include "libfem/mesh/grade/bisect.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <set>

#include "libfem/mesh/boundary.hpp"
#include "libfem/mesh/structured_block.hpp"
#include "libfit/core/error.hpp"
#include "tests/libfem/mesh/grade/bodies_for_tests.hpp"
#include "tests/libfem/mesh/grade/measures.hpp"

namespace palpate::fem {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180;

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

double volume_of(const TetMesh& mesh, double* smallest = nullptr) {
  double sum = 0, least = INFINITY;
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t) {
    const Vec3 a = mesh.nodes.row(mesh.tets(t, 0)), b = mesh.nodes.row(mesh.tets(t, 1)),
               c = mesh.nodes.row(mesh.tets(t, 2)), d = mesh.nodes.row(mesh.tets(t, 3));
    const double volume = (b - a).cross(c - a).dot(d - a) / 6;
    least = std::min(least, volume);
    sum += volume;
  }
  if (smallest) *smallest = least;
  return sum;
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
    double least = 0;
    EXPECT_NEAR(volume_of(mesh, &least), 0.006, 1e-16);
    EXPECT_GT(least, 0);
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
    double least = 0;
    EXPECT_NEAR(volume_of(fine, &least), 4e-4, 4e-16) << "seed " << seed;
    EXPECT_GT(least, 0) << "seed " << seed;
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
    Vec3 centroid = Vec3::Zero();
    for (int k = 0; k < 4; ++k) centroid += 0.25 * fine.nodes.row(fine.tets(t, k));
    EXPECT_LE(size_of(fine, t), wanted_size_m(kPress, centroid) * (1 + 1e-12)) << "tet " << t;
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
  options.halved.pop_back();
  EXPECT_THROW(grade_mesh(base, std::vector<char>(base.nodes.rows(), 0),
                          SmoothSurface({base.nodes, boundary_triangles(base.tets)}), options),
               Error);
}

TEST(Bisect, tets_that_two_regions_share_are_smaller_by_the_share_asked_for) {
  const TetMesh base = shaken_block(5, 0.004);
  GradeOptions options = kPress;
  options.interface_share = 0.5;
  options.region_at = [](const Vec3& x) { return x.z() > 0.031 ? 1 : 0; };
  const TetMesh fine = straight(bisect(base, options));
  int shared = 0;
  for (Eigen::Index t = 0; t < fine.tets.rows(); ++t) {
    Vec3 centroid = Vec3::Zero();
    std::set<int> regions;
    for (int k = 0; k < 4; ++k) {
      centroid += 0.25 * fine.nodes.row(fine.tets(t, k));
      regions.insert(options.region_at(fine.nodes.row(fine.tets(t, k))));
    }
    const double share = regions.size() == 2 ? 0.5 : 1.0;
    shared += regions.size() == 2;
    EXPECT_LE(size_of(fine, t), share * wanted_size_m(options, centroid) * (1 + 1e-12))
        << "tet " << t;
  }
  EXPECT_GT(shared, 50);
  options.interface_share = 0;
  EXPECT_THROW(grade_mesh(base, std::vector<char>(base.nodes.rows(), 0),
                          SmoothSurface({base.nodes, boundary_triangles(base.tets)}), options),
               Error);
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
    const DihedralRange before = dihedral_range(c.base.nodes, c.base.tets);
    const DihedralRange after = dihedral_range(fine.nodes, fine.tets);
    std::printf("%-22s %6ld tets, dihedral %5.1f..%5.1f -> %5.1f..%5.1f degrees\n", c.name,
                static_cast<long>(fine.tets.rows()), before.smallest_rad / kDegree,
                before.largest_rad / kDegree, after.smallest_rad / kDegree,
                after.largest_rad / kDegree);
    EXPECT_GT(after.smallest_rad, c.min_share * before.smallest_rad) << c.name;
  }
}

TEST(Bisect, refinement_without_end_is_refused) {
  GradeOptions options = kPress;
  options.path[0].h_m = 1e-5;
  options.max_corners = 5000;
  try {
    bisect(structured_block({0.1, 0.1, 0.04}, {5, 5, 2}), options);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.fact(), "refinement passes 5000 corner nodes");
  }
}

}  // namespace
}  // namespace palpate::fem
