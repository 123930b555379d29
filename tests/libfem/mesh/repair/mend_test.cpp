// Each defect by name: mended with a sentence, or refused with triangles and places.
#include "libfem/mesh/repair/mend.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <limits>
#include <random>

#include "libfem/mesh/repair/facts.hpp"
#include "libfit/core/text.hpp"
#include "tests/libfem/mesh/repair/shapes.hpp"
#include "tests/support/error_of.hpp"
#include "tests/support/text.hpp"

namespace palpate {
namespace {

using namespace mesh_repair_test;
using testing_support::holds;
using testing_support::plate;

std::string all_changes(const Mended& mended) {
  std::string text;
  for (const std::string& change : mended.changes) text += change + "\n";
  return text;
}

testing::AssertionResult is_sound(const Surface& surface) {
  const SurfaceFacts facts = surface_facts(surface);
  if (facts.is_closed && facts.is_manifold && facts.is_oriented && facts.volume_m3 > 0)
    return testing::AssertionSuccess();
  return testing::AssertionFailure()
         << "border " << facts.border_edges << ", non-manifold " << facts.non_manifold_edges
         << ", pinched " << facts.pinched_vertices << ", unlike " << facts.unlike_edges
         << ", volume " << facts.volume_m3;
}

std::string refusal(const Surface& surface) {
  return testing_support::error_of([&] { mend_surface(surface, {}, "body.obj"); });
}

TEST(Mend, a_sound_surface_comes_back_as_it_was_with_nothing_to_report) {
  const Surface cube = box(0.1);
  const Mended mended = mend_surface(cube, {}, "body.obj");
  EXPECT_TRUE(mended.changes.empty()) << all_changes(mended);
  EXPECT_EQ(mended.surface.vertices, cube.vertices);
  EXPECT_EQ(mended.surface.triangles, cube.triangles);
}

TEST(Mend, vertices_apart_by_roundoff_are_welded) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const Surface cube = box(1);
    const Mended mended = mend_surface(torn(cube, 2e-10, seed), {}, "body.obj");
    EXPECT_EQ(mended.surface.vertices.rows(), cube.vertices.rows()) << "seed " << seed;
    EXPECT_TRUE(is_sound(mended.surface)) << "seed " << seed;
    EXPECT_TRUE(holds(all_changes(mended), "welded 268 duplicate vertices"));
    EXPECT_NEAR(surface_facts(mended.surface).volume_m3, 1, 1e-8);
  }
}

TEST(Mend, vertices_further_apart_are_not_welded) {
  EXPECT_FALSE(holds(refusal(torn(box(1), 1e-6, 1)), "accepted"));
}

TEST(Mend, inside_out_is_turned_outward) {
  const Mended mended = mend_surface(inside_out(box(0.1)), {}, "body.obj");
  EXPECT_TRUE(holds(all_changes(mended), "turned 108 triangles outward"));
  EXPECT_NEAR(surface_facts(mended.surface).volume_m3, 1e-3, 1e-15);
}

TEST(Mend, some_triangles_turned_are_turned_back_and_only_they_are_counted) {
  Surface cube = box(0.1);
  for (const int f : {0, 17, 50}) std::swap(cube.triangles(f, 0), cube.triangles(f, 1));
  const Mended mended = mend_surface(cube, {}, "body.obj");
  EXPECT_TRUE(holds(all_changes(mended), "turned 3 triangles outward"));
  EXPECT_TRUE(is_sound(mended.surface));
}

// An organ and its lesion, merged by a segmentation tool, both outward: it was a cavity, and a
// press on it 37 % too soft. A file turned inside out as a whole says the same of its shells.
TEST(Mend, a_shell_inside_the_body_is_a_cavity_only_where_it_points_against_the_outer_surface) {
  const double solid = surface_facts(ball(0.1)).volume_m3,
               hollow = surface_facts(ball(0.04)).volume_m3;
  for (const bool is_cavity : {true, false}) {
    const Surface both = together(ball(0.1), is_cavity ? inside_out(ball(0.04)) : ball(0.04));
    for (const Surface& as_given : {both, inside_out(both)}) {
      const Mended mended = mend_surface(as_given, {}, "body.obj");
      EXPECT_TRUE(is_sound(mended.surface));
      const SurfaceFacts facts = surface_facts(mended.surface);
      EXPECT_NEAR(facts.volume_m3, solid - (is_cavity ? hollow : 0), 1e-12);
      EXPECT_EQ(facts.cavities, is_cavity ? 1 : 0);
      const std::string text = all_changes(mended);
      EXPECT_EQ(text.find("left out 1 shell inside the body") == std::string::npos, is_cavity);
      if (!is_cavity) {
        EXPECT_TRUE(holds(text, number(1e6 * hollow) + " ml, at (") &&
                    holds(text, "inside = in [[inclusion]]"));
      }
    }
  }
}

TEST(Mend, shells_in_shells_are_body_or_cavity_by_the_side_they_point_to) {
  const auto volume = [](double radius_m) { return surface_facts(ball(radius_m)).volume_m3; };
  // A lesion with a hollow middle; a stone in a cavity, pointing either way.
  const Mended lesion = mend_surface(
      together(together(ball(0.1), ball(0.06)), inside_out(ball(0.02))), {}, "body.obj");
  EXPECT_NEAR(surface_facts(lesion.surface).volume_m3, volume(0.1) - volume(0.02), 1e-12);
  for (const Surface& stone : {ball(0.02), inside_out(ball(0.02))}) {
    const Mended mended =
        mend_surface(together(together(ball(0.1), inside_out(ball(0.06))), stone), {}, "body.obj");
    EXPECT_NEAR(surface_facts(mended.surface).volume_m3, volume(0.1) - volume(0.06) + volume(0.02),
                1e-12);
    EXPECT_EQ(surface_facts(mended.surface).components, 3);
  }
}

TEST(Mend, a_piece_that_begins_inside_and_comes_out_through_the_wall_is_not_left_out) {
  // A block with a pit, and a bar from its depth that goes out through the pit.
  Surface block = box(0.1, Vec3::Zero(), 10);
  for (auto p : block.vertices.rowwise())
    if (p[2] > 0.099 && std::abs(p[0] - 0.05) < 0.025 && std::abs(p[1] - 0.05) < 0.025) p[2] = 0.05;
  const Surface bar = box(0.0171, {0.0413, 0.0422, 0.0437}, 2);
  const std::string text = refusal(together(block, bar));
  EXPECT_TRUE(holds(text, "crosses itself") || holds(text, "moves the rest of the surface"))
      << text;
}

TEST(Mend, what_is_turned_in_a_cavity_is_said_to_be_turned_inward) {
  Surface both = together(ball(0.1), inside_out(ball(0.04)));
  for (const Eigen::Index f : {Eigen::Index{0}, both.triangles.rows() - 1})
    std::swap(both.triangles(f, 0), both.triangles(f, 1));
  const std::string text = all_changes(mend_surface(both, {}, "body.obj"));
  EXPECT_TRUE(holds(text, "turned 1 triangle outward"));
  EXPECT_TRUE(holds(text, "turned 1 triangle of a cavity inward"));
}

TEST(Mend, zero_area_duplicate_and_unused_are_dropped) {
  Surface cube = box(0.1);
  const Vec3 a = cube.vertices.row(cube.triangles(0, 0)),
             b = cube.vertices.row(cube.triangles(0, 1));
  cube =
      with_triangle(cube, a, b, 0.5 * (a + b));  // without area, and its third vertex unused then
  cube = with_triangle(cube, a, b, Vec3(cube.vertices.row(cube.triangles(0, 2))));
  const Mended mended = mend_surface(cube, {}, "body.obj");
  EXPECT_TRUE(is_sound(mended.surface));
  EXPECT_EQ(mended.surface.triangles.rows(), 108);
  EXPECT_TRUE(holds(all_changes(mended), "dropped 1 triangle without area"));
  EXPECT_TRUE(holds(all_changes(mended), "dropped 1 duplicate triangle"));
}

TEST(Mend, a_t_junction_is_split_without_changing_the_volume) {
  // One triangle of the box is replaced by two over the middle of its longest side: the neighbour
  // there still has the whole side.
  Surface cube = box(0.1);
  const Eigen::Vector3i t = cube.triangles.row(0);
  int k = 0;  // the side opposite to the right angle
  for (int i = 0; i < 3; ++i)
    if ((cube.vertices.row(t[i]) - cube.vertices.row(t[(i + 1) % 3])).norm() > 0.04) k = i;
  const Vec3 a = cube.vertices.row(t[k]), b = cube.vertices.row(t[(k + 1) % 3]),
             c = cube.vertices.row(t[(k + 2) % 3]);
  cube = without(cube, {0});
  cube = with_triangle(with_triangle(cube, a, 0.5 * (a + b), c), 0.5 * (a + b), b, c);
  const Mended mended = mend_surface(cube, {}, "body.obj");
  EXPECT_TRUE(is_sound(mended.surface));
  EXPECT_TRUE(holds(all_changes(mended), "split 1 triangle"));
  EXPECT_NEAR(surface_facts(mended.surface).volume_m3, 1e-3, 1e-12);
}

TEST(Mend, a_cap_triangle_gives_its_side_to_the_neighbour) {
  // A triangle whose three vertices lie on a line closes a T-junction only by topology.
  Surface cube = box(0.1);
  const Eigen::Vector3i t = cube.triangles.row(0);
  const Vec3 a = cube.vertices.row(t[0]), b = cube.vertices.row(t[1]), c = cube.vertices.row(t[2]);
  const Vec3 m = 0.5 * (a + b);
  cube = without(cube, {0});
  cube = with_triangle(with_triangle(with_triangle(cube, a, m, c), m, b, c), a, b, m);
  const Mended mended = mend_surface(cube, {}, "body.obj");
  EXPECT_TRUE(is_sound(mended.surface)) << all_changes(mended);
  EXPECT_NEAR(surface_facts(mended.surface).volume_m3, 1e-3, 1e-12);
}

TEST(Mend, a_hole_is_filled_and_its_width_told) {
  const Mended mended = mend_surface(without(box(0.1), {8, 9}), {}, "body.obj");
  EXPECT_TRUE(is_sound(mended.surface));
  EXPECT_TRUE(holds(all_changes(mended), "filled 1 hole (widest 47.1 mm)"));
  EXPECT_NEAR(surface_facts(mended.surface).volume_m3, 1e-3, 1e-12);
}

TEST(Mend, an_open_border_stays_when_allowed) {
  const Mended mended =
      mend_surface(inside_out(without(box(0.1), {8, 9})), {.allow_open = true}, "body.obj");
  const SurfaceFacts facts = surface_facts(mended.surface);
  EXPECT_EQ(facts.border_edges, 4);
  EXPECT_TRUE(facts.is_manifold && facts.is_oriented);
  EXPECT_GT(facts.volume_m3, 0);  // about the first vertex, which the border hardly changes
}

TEST(Mend, stray_pieces_are_dropped_and_larger_ones_kept) {
  const Surface three =
      together(together(box(0.1), box(0.0005, {0.3, 0, 0}, 1)), box(0.02, {0.2, 0, 0}));
  const Mended mended = mend_surface(three, {}, "body.obj");
  EXPECT_EQ(surface_facts(mended.surface).components, 2);
  EXPECT_TRUE(holds(all_changes(mended), "dropped 1 stray piece of 12 triangles"));
}

TEST(Mend, boxes_that_share_an_edge_or_a_corner_are_separated) {
  for (const Vec3& low : {Vec3(0.1, 0.1, 0), Vec3(0.1, 0.1, 0.1)}) {
    const Surface two = together(box(0.1), box(0.1, low));
    const Mended mended = mend_surface(two, {}, "body.obj");
    EXPECT_TRUE(is_sound(mended.surface)) << all_changes(mended);
    EXPECT_EQ(surface_facts(mended.surface).components, 2);
    EXPECT_NEAR(surface_facts(mended.surface).volume_m3, 2e-3, 2e-6);
    EXPECT_TRUE(holds(all_changes(mended), "separated"));
  }
}

// One such facet had a body of 80 mm wrapped to 90.6.
TEST(Mend, stray_facets_are_dropped_beside_a_closed_body_and_on_its_edges_and_vertices) {
  const Surface cube = box(0.1);
  const Vec3 a = cube.vertices.row(cube.triangles(0, 0)),
             b = cube.vertices.row(cube.triangles(0, 1)), away(-0.05, -0.05, -0.05);
  const Surface apart = with_triangle(cube, {0.3, 0, 0}, {0.4, 0, 0}, {0.3, 0.1, 0});
  for (const Surface& with_stray :
       {apart, with_triangle(apart, {0.3, 0.1, 0}, {0.4, 0, 0}, {0.4, 0.1, 2e-4}),
        with_triangle(cube, a, b, away), with_triangle(cube, a, away, {-0.1, 0, -0.05}),
        with_triangle(with_triangle(cube, a, b, {-0.01, -0.01, -0.01}), b, a, {-0.02, 0, -0.01})}) {
    const Mended mended = mend_surface(with_stray, {}, "body.obj");
    EXPECT_TRUE(is_sound(mended.surface));
    EXPECT_EQ(mended.surface.triangles.rows(), 108);
    EXPECT_NEAR(surface_facts(mended.surface).volume_m3, 1e-3, 1e-12);
    EXPECT_TRUE(holds(all_changes(mended), "stray triangle"));
  }
}

TEST(Mend, an_open_piece_that_a_lid_makes_a_body_of_stays) {
  const Mended mended =
      mend_surface(together(box(0.1), without(box(0.03, {0.2, 0, 0}), {8, 9})), {}, "body.obj");
  EXPECT_NEAR(surface_facts(mended.surface).volume_m3, 1e-3 + 27e-6, 1e-9);
}

// A ball of 40 mm with a pit of 38 mm, of `rings` rings of 12 or more triangles.
Surface ball_with_pit(int rings, int around, double radius_m) {
  constexpr double kBall_m = 0.04, kDeep_m = 0.038;
  constexpr int kRest = 24;
  const double start = std::asin(radius_m / kBall_m), top_m = kBall_m * std::cos(start);
  std::vector<Eigen::Vector2d> profile;  // distance from the axis, height
  for (int i = 0; i <= rings; ++i)
    profile.emplace_back(radius_m, top_m - kDeep_m * (1 - double(i) / rings));
  for (int i = 1; i < kRest; ++i) {
    const double angle = start + (std::acos(-1.0) - start) * i / kRest;
    profile.emplace_back(kBall_m * std::sin(angle), kBall_m * std::cos(angle));
  }
  const int n = static_cast<int>(profile.size());
  Surface surface{Points(n * around + 2, 3), Triangles(2 * n * around, 3)};
  surface.vertices.row(0) << 0, 0, top_m - kDeep_m;
  surface.vertices.row(n * around + 1) << 0, 0, -kBall_m;
  const auto vertex = [&](int i, int j) { return 1 + i * around + j % around; };
  for (int i = 0, f = 0; i < n; ++i)
    for (int j = 0; j < around; ++j) {
      const double angle = 2 * std::acos(-1.0) * j / around;
      const auto [from_axis, height] = std::pair(profile[size_t(i)][0], profile[size_t(i)][1]);
      surface.vertices.row(vertex(i, j)) << from_axis * std::cos(angle),
          from_axis * std::sin(angle), height;
      if (i == 0) surface.triangles.row(f++) << 0, vertex(0, j), vertex(0, j + 1);
      if (i == n - 1)
        surface.triangles.row(f++) << n * around + 1, vertex(i, j + 1), vertex(i, j);
      else {
        surface.triangles.row(f++) << vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1);
        surface.triangles.row(f++) << vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1);
      }
    }
  return surface;
}

void push_through(Surface& pit, int vertex) { pit.vertices.row(vertex).head<2>() *= -1.1; }

// Removing its crossings filled the pit, and all that was said is "changed the volume by +2.21 %".
TEST(Mend, a_pit_that_mending_would_fill_is_refused_and_a_spike_through_its_wall_is_taken_off) {
  for (const double radius_m : {0.004, 0.012}) {
    Surface filled = ball_with_pit(1, 12, radius_m);
    for (const int vertex : {2, 24}) push_through(filled, vertex);
    const std::string text = refusal(filled);
    EXPECT_TRUE(holds(text, "moves the rest of the surface by ")) << radius_m;
    EXPECT_TRUE(holds(text, "more than 2 % of its diagonal")) << radius_m;
  }
  Surface spike = ball_with_pit(12, 48, 0.005);
  const double volume_m3 = surface_facts(spike).volume_m3;
  push_through(spike, 1 + 6 * 48 + 20);
  const Mended mended = mend_surface(spike, {}, "body.obj");
  EXPECT_TRUE(holds(all_changes(mended), "which moves the rest of the surface by at most 0."));
  EXPECT_LT(mended.moved_m, 1e-3);
  EXPECT_NEAR(surface_facts(mended.surface).volume_m3 / volume_m3, 1, 1e-3);
}

TEST(Mend, folds_are_removed_and_the_volume_change_told) {
  const Surface sphere = ball(0.05, Vec3::Zero(), 24);
  int removed = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    // The two ends of an edge change places, so that the triangles around cross.
    std::mt19937 random(seed);
    const auto f =
        static_cast<Eigen::Index>(random() % static_cast<unsigned>(sphere.triangles.rows()));
    Surface folded = sphere;
    folded.vertices.row(sphere.triangles(f, 0)) = sphere.vertices.row(sphere.triangles(f, 1));
    folded.vertices.row(sphere.triangles(f, 1)) = sphere.vertices.row(sphere.triangles(f, 0));
    const Mended mended = mend_surface(folded, {}, "body.obj");
    EXPECT_TRUE(is_sound(mended.surface)) << "seed " << seed;
    const bool was_crossing = all_changes(mended).find("crossing pair") != std::string::npos;
    if (was_crossing) {
      EXPECT_TRUE(holds(all_changes(mended), "changed the volume by"));
    }
    removed += was_crossing;
    EXPECT_NEAR(surface_facts(mended.surface).volume_m3 / surface_facts(sphere).volume_m3, 1, 0.01);
  }
  EXPECT_GE(removed, 3);
}

TEST(Mend, two_bodies_through_each_other_are_refused_with_triangles_and_place) {
  const std::string text = refusal(together(ball(0.05), ball(0.05, {0.04, 0, 0})));
  EXPECT_TRUE(holds(text, "body.obj: the surface crosses itself"));
  EXPECT_TRUE(holds(text, "triangles "));
  EXPECT_TRUE(holds(text, ") m"));
  EXPECT_TRUE(holds(text, "wrap"));
}

TEST(Mend, wrapping_makes_one_body_of_two_through_each_other_and_tells_the_distance) {
  const Mended mended = mend_surface(together(ball(0.05), ball(0.05, {0.04, 0, 0})),
                                     {.wrap_alpha_m = 0.006}, "body.obj");
  EXPECT_TRUE(is_sound(mended.surface));
  EXPECT_EQ(surface_facts(mended.surface).components, 1);
  EXPECT_TRUE(holds(all_changes(mended), "Hausdorff distance"));
  // Lens-shaped overlap of two balls of radius R with middles d apart: pi (4R + d)(2R - d)^2 / 12.
  const double R = 0.05, d = 0.04, pi = std::acos(-1.0);
  const double both =
      2 * 4 / 3.0 * pi * R * R * R - pi * (4 * R + d) * (2 * R - d) * (2 * R - d) / 12;
  EXPECT_NEAR(surface_facts(mended.surface).volume_m3 / both, 1, 0.05);
}

TEST(Mend, a_wrap_leaves_stray_facets_out) {
  const Surface two = together(ball(0.05), ball(0.05, {0.04, 0, 0}));
  const Mended mended =
      mend_surface(with_triangle(two, {0, 0, 0.1}, {0.01, 0, 0.1}, {0, 0.01, 0.1}),
                   {.wrap_alpha_m = 0.006}, "body.obj");
  EXPECT_TRUE(mended.is_wrapped);
  EXPECT_TRUE(holds(all_changes(mended), "dropped 1 stray triangle"));
  EXPECT_LT(mended.surface.vertices.col(2).maxCoeff(), 0.052);
}

// It was refused as one that crosses itself: the sheet with its lid, two triangles on two others.
TEST(Mend, an_open_sheet_is_refused_as_open) {
  const std::string text = refusal(plate(1, 1, 0.1, 0.1));
  EXPECT_TRUE(holds(text, "body.obj: the surface is open: 4 open edges, one at (")) << text;
  EXPECT_TRUE(holds(text, "Close it in a mesh editor")) << text;
}

TEST(Mend, wrapping_an_open_sheet_is_refused_as_a_hollow_shell) {
  const std::string text = testing_support::error_of(
      [] { mend_surface(plate(10, 10, 0.1, 0.1), {.wrap_alpha_m = 0.006}, "face.obj"); });
  EXPECT_TRUE(holds(text, "face.obj: wrapped with alpha 6 mm it is a hollow shell"));
  EXPECT_TRUE(holds(text, "\n  Close the openings"));
}

TEST(Mend, wrapping_a_box_with_an_open_bottom_fills_it_and_says_so) {
  // A ball through its top keeps it from being mended.
  const Surface closed = box(0.1, Vec3::Zero(), 5);
  std::vector<Eigen::Index> bottom;
  for (Eigen::Index f = 0; f < closed.triangles.rows(); ++f)
    if (closed.vertices(closed.triangles(f, 0), 2) + closed.vertices(closed.triangles(f, 1), 2) +
            closed.vertices(closed.triangles(f, 2), 2) <
        1e-9)
      bottom.push_back(f);
  ASSERT_EQ(bottom.size(), 50u);
  const Surface open = together(without(closed, bottom), ball(0.02, {0.05, 0.05, 0.1}, 24));
  const Mended mended = mend_surface(open, {.wrap_alpha_m = 0.006}, "box.obj");
  EXPECT_TRUE(is_sound(mended.surface));
  EXPECT_TRUE(holds(all_changes(mended), "filled 1 hole (widest 141"));
  EXPECT_NEAR(surface_facts(mended.surface).volume_m3, 1e-3, 0.06e-3);
}

TEST(Mend, a_moebius_strip_is_refused_as_one_sided) {
  constexpr int n = 12;
  Surface strip{Points(2 * n, 3), Triangles(2 * n, 3)};
  for (int i = 0; i < n; ++i) {
    const double turn = 2 * std::acos(-1.0) * i / n;
    for (const int s : {0, 1}) {
      const double w = (s - 0.5) * 0.4, r = 1 + w * std::cos(turn / 2);
      strip.vertices.row(2 * i + s) << r * std::cos(turn), r * std::sin(turn),
          w * std::sin(turn / 2);
    }
    const int a = 2 * i, b = a + 1, c = i + 1 < n ? a + 2 : 1, d = i + 1 < n ? a + 3 : 0;
    strip.triangles.row(2 * i) << a, b, c;
    strip.triangles.row(2 * i + 1) << b, d, c;
  }
  EXPECT_TRUE(holds(refusal(strip), "only one side"));
}

TEST(Mend, what_is_no_surface_is_refused) {
  Surface cube = box(0.1);
  cube.vertices.setZero();
  EXPECT_TRUE(holds(refusal(cube), "one place"));
  cube = box(0.1);
  cube.vertices.col(1).setZero();
  cube.vertices.col(2).setZero();
  EXPECT_TRUE(holds(refusal(cube), "no triangle of the surface has an area"));
}

}  // namespace
}  // namespace palpate
