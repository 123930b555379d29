#include "libfit/refine/refine.hpp"

#include <gtest/gtest.h>

#include "tests/libfit/refine/blending.hpp"

namespace palpate::testing_refine {
namespace {

TEST(Refine, an_open_sheet_is_covered_one_spacing_beyond_its_outermost_points) {
  const Surface fine = plate(100, 20, 0.2, 0.04);
  Surface points = plate(4, 4, 0.04, 0.04);  // spacing 10 mm, triangle edges up to 14.1 mm
  RefineReport report;
  const Model model =
      refine(curves_at(points, kSmooth), fine, all(fine), points.triangles, {}, &report);
  for (Eigen::Index v = 0; v < fine.vertices.rows(); ++v) {
    const double x = fine.vertices(v, 0);
    if (x < 0.050) {
      EXPECT_TRUE(model.is_covered[static_cast<std::size_t>(v)]) << "x " << x;
    }
    if (x > 0.055) {
      EXPECT_FALSE(model.is_covered[static_cast<std::size_t>(v)]) << "x " << x;
    }
  }
  EXPECT_NEAR(report.largest_projection_m, std::sqrt(2e-4), 0.0021);
  for (const std::int32_t v : report.uncovered) {
    EXPECT_FALSE(model.is_covered[static_cast<std::size_t>(v)]);
    EXPECT_TRUE(model.curves.control[0].row(v).isZero(0));
  }
  expect_partition_of_unity(model);
}

TEST(Refine, points_on_part_of_a_closed_surface_do_not_close_it_behind_them) {
  const Surface fine = icosphere(5, 0.03), ball = icosphere(3, 0.03);
  Surface cap;  // test points of the upper half only
  std::vector<int> kept;
  for (Eigen::Index i = 0; i < ball.vertices.rows(); ++i)
    if (ball.vertices(i, 2) > -1e-9) kept.push_back(int(i));
  cap.vertices = ball.vertices(kept, Eigen::all);
  FittedCurves curves = curves_at(cap, kSmooth);
  curves.normal = -cap.vertices / 0.03;
  RefineReport report;
  const Model model = refine(curves, fine, all(fine), kNone, {}, &report);
  for (Eigen::Index v = 0; v < fine.vertices.rows(); ++v) {
    if (fine.vertices(v, 2) > 0) {
      EXPECT_TRUE(model.is_covered[static_cast<std::size_t>(v)]);
    }
    if (fine.vertices(v, 2) < -0.012) {
      EXPECT_FALSE(model.is_covered[static_cast<std::size_t>(v)]) << fine.vertices.row(v);
    }
  }
}

TEST(Refine, vertices_that_are_not_reachable_are_not_covered) {
  const Surface fine = plate(20, 20, 0.1, 0.1), points = plate(5, 5, 0.1, 0.1);
  std::vector<char> is_reachable = all(fine);
  is_reachable[7] = is_reachable[200] = 0;
  RefineReport report;
  const Model model =
      refine(curves_at(points, kSmooth), fine, is_reachable, points.triangles, {}, &report);
  EXPECT_EQ(model.is_covered, is_reachable);
  EXPECT_TRUE(model.curves.control[0].row(7).isZero(0));
  EXPECT_TRUE(report.uncovered.empty()) << "nobody asked for them";
}

TEST(Refine, a_failed_point_gives_its_weight_to_the_others) {
  const Surface fine = plate(40, 40, 0.1, 0.1), points = plate(4, 4, 0.1, 0.1);
  FittedCurves curves = curves_at(points, [](const Vec3&) { return 2; });
  const std::int32_t failed = 12;  // the middle
  curves.status[12] = FitStatus::failed;
  for (auto& control : curves.curves.control) control.row(12).setConstant(std::nan(""));
  for (const Triangles& triangles : {points.triangles, kNone}) {
    RefineReport report;
    const Model model = refine(curves, fine, all(fine), triangles, {}, &report);
    EXPECT_EQ(report.left_out, std::vector<std::int32_t>{failed});
    EXPECT_TRUE(report.uncovered.empty());
    expect_partition_of_unity(model);
    for (Eigen::Index v = 0; v < fine.vertices.rows(); ++v) {
      EXPECT_NEAR(model.curves.control[0](v, 1), 2, 1e-6) << "vertex " << v;
      for (int k = 0; k < 3; ++k)
        if (model.blend_point(v, k) == failed) {
          EXPECT_EQ(model.blend_weight(v, k), 0);
        }
    }
  }
}

TEST(Refine, where_all_points_failed_nothing_is_covered) {
  const Surface fine = plate(20, 20, 0.1, 0.1), points = plate(4, 4, 0.1, 0.1);
  FittedCurves curves = curves_at(points, kSmooth);
  curves.status.assign(curves.status.size(), FitStatus::failed);
  for (const Triangles& triangles : {points.triangles, kNone}) {
    RefineReport report;
    const Model model = refine(curves, fine, all(fine), triangles, {}, &report);
    EXPECT_EQ(report.uncovered.size(), static_cast<std::size_t>(fine.vertices.rows()));
    EXPECT_TRUE(model.curves.control[0].isZero(0));
  }
}

TEST(Refine, one_or_two_points_answer_for_their_cells) {
  const Surface fine = plate(20, 20, 0.1, 0.1);
  Surface two;
  two.vertices.resize(2, 3);
  two.vertices << 0.02, 0.05, 0, 0.08, 0.05, 0;
  FittedCurves curves = curves_at(two, [](const Vec3& p) { return p.x() < 0.05 ? 1 : 2; });
  curves.normal.rowwise() = Eigen::RowVector3d(0, 0, -1);
  RefineReport report;
  const Model model = refine(curves, fine, all(fine), kNone, {}, &report);
  EXPECT_TRUE(report.uncovered.empty());
  for (Eigen::Index v = 0; v < fine.vertices.rows(); ++v) {
    if (fine.vertices(v, 0) < 0.0499) {
      EXPECT_EQ(model.curves.control[0](v, 1), 1);
    }
    if (fine.vertices(v, 0) > 0.0501) {
      EXPECT_EQ(model.curves.control[0](v, 1), 2);
    }
  }
}

TEST(Refine, points_off_the_surface_are_left_out_and_listed) {
  const Surface fine = plate(20, 20, 0.1, 0.1), points = plate(4, 4, 0.1, 0.1);
  FittedCurves curves = curves_at(points, kSmooth);
  curves.position(3, 2) = 0.05;
  RefineReport report;
  refine(curves, fine, all(fine), kNone, {}, &report);
  EXPECT_EQ(report.left_out, std::vector<std::int32_t>{3});
}

}  // namespace
}  // namespace palpate::testing_refine
