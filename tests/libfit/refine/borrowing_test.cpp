#include "libfit/refine/refine.hpp"

#include <gtest/gtest.h>

#include "tests/libfit/refine/blending.hpp"

namespace palpate::testing_refine {
namespace {

TEST(Refine, plates_one_millimetre_apart_do_not_borrow) {
  const Surface lower = plate(40, 40, 0.1, 0.1), upper = plate(40, 40, 0.1, 0.1, 0.001);
  const Surface points = plate(5, 5, 0.1, 0.1);  // on the lower plate only; both face up
  const Surface both = together(lower, upper);
  for (const Triangles& triangles : {points.triangles, kNone}) {
    RefineReport report;
    const Model model = refine(curves_at(points, kSmooth), both, all(both), triangles, {}, &report);
    for (Eigen::Index v = 0; v < both.vertices.rows(); ++v)
      EXPECT_EQ(bool(model.is_covered[static_cast<std::size_t>(v)]), v < lower.vertices.rows());
    EXPECT_EQ(report.uncovered.size(), static_cast<std::size_t>(upper.vertices.rows()));
  }
}

TEST(Refine, banks_of_a_slit_do_not_borrow) {
  const Surface left = plate(20, 40, 0.0495, 0.1);
  Surface right = plate(20, 40, 0.0495, 0.1);
  right.vertices.col(0).array() += 0.0505;  // 1 mm slit
  Surface left_points = plate(3, 5, 0.0495, 0.1), right_points = left_points;
  right_points.vertices.col(0).array() += 0.0505;
  const Surface fine = together(left, right), points = together(left_points, right_points);
  const Field step = [](const Vec3& p) { return p.x() < 0.05 ? 1 : 9; };
  const Model model = refine(curves_at(points, step), fine, all(fine), kNone);
  EXPECT_LT(field_error(model, step).most, 1e-6);
  EXPECT_EQ(field_error(model, step).covered, fine.vertices.rows());
}

// A sheet 1 mm thick whose edge is rounded (radius 0.5 mm) and bent in a circle of 50 mm, like the
// rim of an organ: upper side, rim, lower side, each side 30 mm wide.
Vec3 rim(double s, double angle) {
  const double side = 0.03, turn = 0.0005 * M_PI;
  double from_rim = 0, z = 0.0005;
  if (s < side) {
    from_rim = side - s;
  } else if (s < side + turn) {
    from_rim = -0.0005 * std::sin((s - side) / 0.0005);
    z = 0.0005 * std::cos((s - side) / 0.0005);
  } else {
    from_rim = s - side - turn;
    z = -0.0005;
  }
  const double radius = 0.05 - from_rim;
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

TEST(Refine, sides_of_a_thin_curved_rim_do_not_borrow) {
  const double length = 0.06 + 0.0005 * M_PI;
  const auto over = [&](int across, int along) {
    return sheet(across, along,
                 [&](double u, double v) { return rim(length * u, M_PI * (1 - v)); });
  };
  const Surface fine = over(246, 160);
  // Points on the two sides and on the rim's crest; the sides answer differently.
  const Surface coarse = over(12, 20);
  const Field by_side = [](const Vec3& p) { return p.z() > 0 ? 1.0 : 9.0; };
  for (const Triangles& triangles : {coarse.triangles, kNone}) {
    const Model model = refine(curves_at(coarse, by_side), fine, all(fine), triangles);
    int upper = 0, lower = 0;
    for (Eigen::Index v = 0; v < fine.vertices.rows(); ++v) {
      const double from_rim = 0.05 - fine.vertices.row(v).head(2).norm();
      if (from_rim < 0.0055) continue;  // within a spacing of the crest, blends are meant
      const bool is_upper = fine.vertices(v, 2) > 0;
      ASSERT_TRUE(model.is_covered[static_cast<std::size_t>(v)]) << "vertex " << v;
      EXPECT_EQ(model.curves.control[0](v, 1), is_upper ? 1 : 9) << "vertex " << v;
      ++(is_upper ? upper : lower);
    }
    EXPECT_GT(upper, fine.vertices.rows() / 3);
    EXPECT_GT(lower, fine.vertices.rows() / 3);
  }
}

}  // namespace
}  // namespace palpate::testing_refine
