#include "libfit/refine/refine.hpp"

#include <gtest/gtest.h>

#include <random>

#include "libfit/core/error.hpp"
#include "tests/libfit/refine/blending.hpp"

namespace palpate::testing_refine {
namespace {

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
        blended +=
            model.blend_weight(v, k) * points.vertices.row(model.blend_point(v, k)).transpose();
      EXPECT_LT((blended.transpose() - fine.vertices.row(v)).norm(), 1e-16 * 10) << "vertex " << v;
      EXPECT_NEAR(model.curves.control[2](v, 1), linear(fine.vertices.row(v)), 5e-7);
    }
  }
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

TEST(Refine, answers_alike_twice_and_whatever_the_size_of_the_body) {
  const Surface fine = icosphere(4, 0.03), points = icosphere(2, 0.03);
  const FittedCurves curves = curves_at(points, kSmooth);
  const Model a = refine(curves, fine, all(fine), kNone),
              b = refine(curves, fine, all(fine), kNone);
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
  const auto fact = [&](const FittedCurves& c, const std::vector<char>& reachable,
                        const Triangles& t) {
    try {
      refine(c, fine, reachable, t);
    } catch (const Error& error) {
      return error.fact();
    }
    return std::string();
  };
  Triangles beyond(1, 3);
  beyond << 0, 1, 9;
  EXPECT_EQ(fact(curves, all(fine), beyond),
            "a test-point triangle names a point that is not there");
  EXPECT_EQ(fact(curves, {1}, kNone), "the body's columns differ in length");
  EXPECT_EQ(fact(FittedCurves{}, all(fine), kNone), "the curves hold no test point");
}

}  // namespace
}  // namespace palpate::testing_refine
