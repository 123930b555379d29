#include "libfit/refine/refine.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "libfit/core/error.hpp"
#include "libfit/refine/match_triangles.hpp"
#include "tests/libfit/refine/surfaces.hpp"

namespace palpate::testing_refine {
namespace {

const Triangles kNone(0, 3);
const Field kSmooth = [](const Vec3& p) {
  return 3 + std::sin(60 * p.x()) + 0.5 * std::cos(50 * p.y() + 1) + 40 * p.z() * p.x();
};

// Root mean square and largest error of the first normal control value over covered vertices.
struct FieldError {
  double rms = 0, most = 0;
  int covered = 0;
};
FieldError field_error(const Model& model, const Field& field) {
  FieldError error;
  for (Eigen::Index v = 0; v < model.surface.vertices.rows(); ++v) {
    if (!model.is_covered[static_cast<std::size_t>(v)]) continue;
    const double e = std::abs(model.curves.control[0](v, 1) - field(model.surface.vertices.row(v)));
    error.rms += e * e;
    error.most = std::max(error.most, e);
    ++error.covered;
  }
  error.rms = std::sqrt(error.rms / error.covered);
  return error;
}

void expect_partition_of_unity(const Model& model) {
  for (Eigen::Index v = 0; v < model.blend_weight.rows(); ++v) {
    EXPECT_GE(model.blend_weight.row(v).minCoeff(), 0) << "vertex " << v;
    const double sum = model.is_covered[static_cast<std::size_t>(v)] ? 1 : 0;
    EXPECT_NEAR(model.blend_weight.row(v).sum(), sum, 1e-14) << "vertex " << v;
  }
}

TEST(Refine, weights_are_a_partition_of_unity) {
  const Surface sphere = icosphere(4, 0.03), points = icosphere(1, 0.03);
  expect_partition_of_unity(refine(curves_at(points, kSmooth), sphere, all(sphere), points.triangles));
  expect_partition_of_unity(refine(curves_at(points, kSmooth), sphere, all(sphere), kNone));
}

TEST(Refine, linear_fields_on_a_plate_come_out_exactly) {
  const Surface fine = plate(40, 33, 0.1, 0.08), points = plate(5, 4, 0.1, 0.08);
  const Field linear = [](const Vec3& p) { return 2 + 7 * p.x() - 11 * p.y(); };
  for (const Triangles& triangles : {points.triangles, kNone}) {
    const FittedCurves curves = curves_at(points, linear);
    RefineReport report;
    const Model model = refine(curves, fine, all(fine), triangles, {}, &report);
    EXPECT_TRUE(report.uncovered.empty());
    for (Eigen::Index v = 0; v < fine.vertices.rows(); ++v) {
      Vec3 blended = Vec3::Zero();
      for (int k = 0; k < 3; ++k)
        blended += model.blend_weight(v, k) * points.vertices.row(model.blend_point(v, k)).transpose();
      EXPECT_LT((blended.transpose() - fine.vertices.row(v)).norm(), 1e-16 * 10) << "vertex " << v;
      EXPECT_NEAR(model.curves.control[2](v, 1), linear(fine.vertices.row(v)), 5e-7);
    }
  }
}

// Observed order between successive halvings of the spacing, from root mean square errors.
std::vector<double> orders(const std::vector<FieldError>& errors, double FieldError::*measure) {
  std::vector<double> orders;
  for (std::size_t i = 1; i < errors.size(); ++i)
    orders.push_back(std::log2(errors[i - 1].*measure / errors[i].*measure));
  return orders;
}

TEST(Refine, converges_with_second_order_on_a_sphere) {
  const Surface fine = icosphere(6, 0.03);
  std::vector<FieldError> errors;
  for (int level = 2; level <= 4; ++level) {
    const Surface points = icosphere(level, 0.03);
    const Model model = refine(curves_at(points, kSmooth), fine, all(fine), points.triangles);
    errors.push_back(field_error(model, kSmooth));
    EXPECT_EQ(errors.back().covered, fine.vertices.rows());
  }
  for (const double order : orders(errors, &FieldError::rms)) EXPECT_GE(order, 1.9);
  for (const double order : orders(errors, &FieldError::most)) EXPECT_GE(order, 1.8);
  RecordProperty("rms_orders", testing::PrintToString(orders(errors, &FieldError::rms)));
  RecordProperty("max_orders", testing::PrintToString(orders(errors, &FieldError::most)));
}

TEST(Refine, converges_with_second_order_on_a_cylinder) {
  const Surface fine = cylinder(192, 96, 0.03, 0.1);
  std::vector<FieldError> errors;
  for (const int n : {12, 24, 48}) {
    const Surface points = cylinder(n, n / 2, 0.03, 0.1);
    const Model model = refine(curves_at(points, kSmooth), fine, all(fine), points.triangles);
    errors.push_back(field_error(model, kSmooth));
    EXPECT_EQ(errors.back().covered, fine.vertices.rows());
  }
  for (const double order : orders(errors, &FieldError::rms)) EXPECT_GE(order, 1.9);
  RecordProperty("rms_orders", testing::PrintToString(orders(errors, &FieldError::rms)));
}

TEST(Refine, converges_with_second_order_on_its_own_triangulation) {
  const Surface fine = icosphere(6, 0.03);
  std::vector<FieldError> errors;
  for (int level = 2; level <= 4; ++level) {
    RefineReport report;
    const Surface points = icosphere(level, 0.03);
    const Model model = refine(curves_at(points, kSmooth), fine, all(fine), kNone, {}, &report);
    EXPECT_TRUE(report.is_own_triangulation);
    EXPECT_EQ(report.triangles.rows(), points.triangles.rows()) << "2 P - 4 on a sphere";
    errors.push_back(field_error(model, kSmooth));
    EXPECT_EQ(errors.back().covered, fine.vertices.rows());
  }
  for (const double order : orders(errors, &FieldError::rms)) EXPECT_GE(order, 1.9);
  RecordProperty("rms_orders", testing::PrintToString(orders(errors, &FieldError::rms)));
}

// Points of a rig, at no vertex: evenly spread by the golden angle, each moved at random by up to
// a quarter of the spacing.
Surface scattered_on_sphere(int points, double radius_m, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-1, 1);
  const double spacing = std::sqrt(4 * M_PI / points);
  Surface s;
  s.vertices.resize(points, 3);
  for (int i = 0; i < points; ++i) {
    const double z = 1 - (2 * i + 1.0) / points, angle = i * M_PI * (3 - std::sqrt(5.0));
    Vec3 p(std::sqrt(1 - z * z) * std::cos(angle), std::sqrt(1 - z * z) * std::sin(angle), z);
    p += 0.25 * spacing / std::sqrt(3.0) * Vec3(shift(random), shift(random), shift(random));
    s.vertices.row(i) = radius_m * p.normalized().transpose();
  }
  return s;
}

TEST(Refine, converges_with_second_order_on_scattered_points) {
  const Surface fine = icosphere(6, 0.03);
  std::vector<FieldError> errors;
  for (const int count : {160, 640, 2560}) {
    const Surface points = scattered_on_sphere(count, 0.03, 7);
    FittedCurves curves = curves_at(points, kSmooth);
    curves.normal = -points.vertices / 0.03;
    RefineReport report;
    const Model model = refine(curves, fine, all(fine), kNone, {}, &report);
    EXPECT_EQ(report.triangles.rows(), 2 * count - 4) << "a closed triangulation, seed 7";
    errors.push_back(field_error(model, kSmooth));
    EXPECT_EQ(errors.back().covered, fine.vertices.rows());
  }
  for (const double order : orders(errors, &FieldError::rms)) EXPECT_GE(order, 1.9) << "seed 7";
  RecordProperty("rms_orders", testing::PrintToString(orders(errors, &FieldError::rms)));
}

TEST(Refine, monotone_controls_stay_monotone_and_start_at_zero) {
  const Surface fine = icosphere(4, 0.03), points = icosphere(1, 0.03);
  for (unsigned seed = 1; seed <= 5; ++seed) {
    FittedCurves curves = curves_at(points, kSmooth);
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> increment(-1e-3f, 1e-3f);  // half of them flat
    curves.curves.basis[0] = {3, {0, 0.002, 0.005, 0.01}};
    curves.curves.control[0] = Controls::Zero(points.vertices.rows(), 6);
    for (Eigen::Index i = 0; i < points.vertices.rows(); ++i)
      for (int j = 1; j < 6; ++j)
        curves.curves.control[0](i, j) =
            float(curves.curves.control[0](i, j - 1)) + std::max(0.0f, increment(random));
    curves.curves.control[0] = curves.curves.control[0].cast<float>().cast<double>();
    const Controls fine_control =
        refine(curves, fine, all(fine), points.triangles).curves.control[0];
    for (Eigen::Index v = 0; v < fine_control.rows(); ++v) {
      EXPECT_EQ(fine_control(v, 0), 0);
      for (int j = 1; j < 6; ++j)
        EXPECT_GE(fine_control(v, j), fine_control(v, j - 1)) << "seed " << seed << " vertex " << v;
    }
    EXPECT_EQ(fine_control, Controls(fine_control.cast<float>().cast<double>()));
  }
}

TEST(Refine, a_vertex_at_a_test_point_keeps_its_curves_exactly) {
  const Surface fine = icosphere(4, 0.03), points = icosphere(2, 0.03);  // the first 162 coincide
  FittedCurves curves = curves_at(points, kSmooth);
  curves.position *= 1 + 1e-13;  // as after a round trip through another frame
  for (const Triangles& triangles : {points.triangles, kNone}) {
    const Model model = refine(curves, fine, all(fine), triangles);
    for (Eigen::Index i = 0; i < points.vertices.rows(); ++i) {
      EXPECT_EQ(model.blend_weight.row(i).maxCoeff(), 1);
      EXPECT_EQ(model.curves.control[1].row(i), curves.curves.control[1].row(i));
    }
  }
}

TEST(Refine, inward_normals_point_to_the_centre_of_a_sphere) {
  const Surface fine = icosphere(3, 0.03);
  const Model model = refine(curves_at(fine, kSmooth), fine, all(fine), fine.triangles);
  for (Eigen::Index v = 0; v < fine.vertices.rows(); ++v)
    EXPECT_GT(-model.inward_normal.row(v).dot(fine.vertices.row(v)) / 0.03, 0.999);
}

TEST(Refine, plates_one_millimetre_apart_do_not_borrow) {
  const Surface lower = plate(40, 40, 0.1, 0.1), upper = plate(40, 40, 0.1, 0.1, 0.001);
  const Surface points = plate(5, 5, 0.1, 0.1);  // on the lower plate only; both face up
  const Surface both = together(lower, upper);
  for (const Triangles& triangles : {points.triangles, kNone}) {
    RefineReport report;
    const Model model =
        refine(curves_at(points, kSmooth), both, all(both), triangles, {}, &report);
    for (Eigen::Index v = 0; v < both.vertices.rows(); ++v)
      EXPECT_EQ(bool(model.is_covered[static_cast<std::size_t>(v)]), v < lower.vertices.rows());
    EXPECT_EQ(report.uncovered.size(), static_cast<std::size_t>(upper.vertices.rows()));
  }
}

TEST(Refine, the_far_side_of_a_one_millimetre_sheet_does_not_borrow) {
  Surface lower = plate(40, 40, 0.1, 0.1, -0.001);
  lower.triangles.col(1).swap(lower.triangles.col(2));  // faces down
  const Surface upper = plate(40, 40, 0.1, 0.1), both = together(upper, lower);
  const Surface points = plate(5, 5, 0.1, 0.1);
  const Model model = refine(curves_at(points, kSmooth), both, all(both), kNone);
  for (Eigen::Index v = 0; v < both.vertices.rows(); ++v)
    EXPECT_EQ(bool(model.is_covered[static_cast<std::size_t>(v)]), v < upper.vertices.rows());
}

// Length along a strip folded twice: three layers of 50 mm, 1 mm apart; the first and the third
// face up, 2 mm apart.
Vec3 folded(double s) {
  if (s < 0.05) return {s, 0, 0.002};
  if (s < 0.051) return {0.05, 0, 0.002 - (s - 0.05)};
  if (s < 0.101) return {0.05 - (s - 0.051), 0, 0.001};
  if (s < 0.102) return {0, 0, 0.001 - (s - 0.101)};
  return {s - 0.102, 0, 0};
}

TEST(Refine, layers_of_a_fold_do_not_borrow) {
  const Surface fine = sheet(304, 40, [](double u, double v) {
    return Vec3(folded(0.152 * u) + Vec3(0, 0.05 * v, 0));
  });
  const Surface points = plate(5, 5, 0.05, 0.05, 0.002);  // on the first layer only
  for (const Triangles& triangles : {points.triangles, kNone}) {
    const Model model = refine(curves_at(points, kSmooth), fine, all(fine), triangles);
    int covered = 0;
    for (Eigen::Index v = 0; v < fine.vertices.rows(); ++v) {
      // The second faces down and begins within reach of the points, the third faces up far away.
      const bool is_other_layer = fine.vertices(v, 2) < 0.0011;
      if (is_other_layer) {
        EXPECT_FALSE(model.is_covered[static_cast<std::size_t>(v)]) << "vertex " << v;
      }
      covered += model.is_covered[static_cast<std::size_t>(v)];
    }
    EXPECT_GT(covered, fine.vertices.rows() / 4) << "the first layer";
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

TEST(Refine, answers_alike_twice_and_whatever_the_size_of_the_body) {
  const Surface fine = icosphere(4, 0.03), points = icosphere(2, 0.03);
  const FittedCurves curves = curves_at(points, kSmooth);
  const Model a = refine(curves, fine, all(fine), kNone), b = refine(curves, fine, all(fine), kNone);
  EXPECT_EQ(a.blend_point, b.blend_point);
  EXPECT_EQ(a.blend_weight, b.blend_weight);
  Surface large = fine;
  large.vertices *= 1024;
  FittedCurves large_curves = curves;
  large_curves.position *= 1024;
  const Model c = refine(large_curves, large, all(large), kNone);
  EXPECT_EQ(a.blend_point, c.blend_point);
  EXPECT_EQ(a.blend_weight, c.blend_weight);
}

TEST(Refine, nonsense_is_refused) {
  const Surface fine = plate(2, 2, 0.1, 0.1);
  FittedCurves curves = curves_at(fine, kSmooth);
  const auto fact = [&](const FittedCurves& c, const std::vector<char>& reachable, const Triangles& t) {
    try {
      refine(c, fine, reachable, t);
    } catch (const Error& error) {
      return error.fact();
    }
    return std::string();
  };
  Triangles beyond(1, 3);
  beyond << 0, 1, 9;
  EXPECT_EQ(fact(curves, all(fine), beyond), "a test-point triangle names a point that is not there");
  EXPECT_EQ(fact(curves, {1}, kNone), "the body's columns differ in length");
  EXPECT_EQ(fact(FittedCurves{}, all(fine), kNone), "the curves hold no test point");
}

TEST(MatchTriangles, follow_points_given_in_another_order) {
  const Surface points = icosphere(2, 0.03);
  TestPoints test_points;
  test_points.position = points.vertices;
  test_points.triangles = points.triangles;
  std::vector<int> order(static_cast<std::size_t>(points.vertices.rows()));
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), std::mt19937(3));
  Points shuffled = points.vertices(order, Eigen::all);
  shuffled.array() += 1e-9;  // rounded on the way: less than 1e-6 of the body
  const Triangles matched = match_triangles(shuffled, test_points, 0.1);
  ASSERT_EQ(matched.rows(), points.triangles.rows());
  for (Eigen::Index t = 0; t < matched.rows(); ++t)
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(order[static_cast<std::size_t>(matched(t, k))], points.triangles(t, k));
}

TEST(MatchTriangles, other_points_have_none) {
  const Surface points = icosphere(1, 0.03);
  TestPoints test_points;
  test_points.position = points.vertices;
  test_points.triangles = points.triangles;
  Points moved = points.vertices;
  moved(5, 1) += 1e-5;
  EXPECT_EQ(match_triangles(moved, test_points, 0.1).rows(), 0);
  EXPECT_EQ(match_triangles(points.vertices.topRows(41), test_points, 0.1).rows(), 0);
  Points twice = points.vertices;
  twice.row(1) = twice.row(0);
  EXPECT_EQ(match_triangles(twice, test_points, 0.1).rows(), 0);
}

TEST(MatchTriangles, a_body_is_refined_on_its_own_triangulation) {
  Body body;
  body.surface = icosphere(4, 0.03);
  body.is_reachable = all(body.surface);
  const Surface points = icosphere(1, 0.03);
  body.test_points.position = points.vertices;
  body.test_points.triangles = points.triangles;
  RefineReport report;
  FittedCurves curves = curves_at(points, kSmooth);
  refine(curves, body, {}, &report);
  EXPECT_FALSE(report.is_own_triangulation);
  curves.position(0, 0) += 1e-4;
  refine(curves, body, {}, &report);
  EXPECT_TRUE(report.is_own_triangulation);
}

}  // namespace
}  // namespace palpate::testing_refine
