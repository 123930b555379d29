// What a side force says of the slope of the normal curve, and what blending gains by it.

#include "libfit/refine/interpolation.hpp"

#include <gtest/gtest.h>

#include <random>

#include "libfit/refine/next_points.hpp"
#include "tests/libfit/refine/blending.hpp"

namespace palpate::testing_refine {
namespace {

constexpr double kDepth = 0.006;

Vec3 gradient(const Field& field, const Vec3& at) {
  constexpr double h = 1e-6;
  Vec3 out;
  for (int k = 0; k < 3; ++k)
    out[k] = (field(at + h * Vec3::Unit(k)) - field(at - h * Vec3::Unit(k))) / (2 * h);
  return out;
}

// Rings whose normal curve is a line, control value 1 the field, on a surface that counts as flat;
// the side force is the slope of what they store.
// normals: outward ones, exact; empty: of the triangles, which at an open border see one side.
using Normals = std::function<Vec3(const Vec3&)>;
FittedCurves rings_at(const Surface& points, const Field& field, const Normals& normals = {}) {
  FittedCurves out = curves_at(points, field);
  for (Eigen::Index p = 0; p < out.normal.rows() && normals; ++p)
    out.normal.row(p) = -normals(points.vertices.row(p)).normalized();
  const Eigen::Index count = points.vertices.rows();
  out.curves = CurveSet(CurveFamily::rings);
  out.curves.basis[0] = {3, {0, kDepth}};
  const auto parts = parts_of(CurveFamily::rings);
  for (std::size_t i = 0; i < parts.size(); ++i)
    out.curves.control[i] =
        Controls::Zero(count, parts[i].width * size_of(parts[i], out.curves.basis[i]));
  for (Eigen::Index p = 0; p < count; ++p) {
    const Vec3 at = points.vertices.row(p), u = out.normal.row(p);
    for (int j = 0; j < 4; ++j) out.curves.control[0](p, j) = j * field(at);
    const Vec3 along = gradient(field, at);
    out.curves.control[runtime::kSide2].row(p) =
        1.5 / kDepth * (along - u * u.dot(along)).transpose();
  }
  return out;
}

// The same points of which no press says anything of slopes.
FittedCurves without_side_force(FittedCurves curves) {
  curves.curves.control[runtime::kSide2].setZero();
  return curves;
}

void expect_third_order(const std::vector<Surface>& points, const Surface& fine,
                        const Normals& normals = {}) {
  std::vector<double> errors, orders;
  for (const Surface& each : points) {
    RefineReport report;
    const Model model =
        refine(rings_at(each, kSmooth, normals), fine, all(fine), each.triangles, {}, &report);
    EXPECT_EQ(report.interpolation.slope_share, 0.5) << "chosen by leaving points out";
    errors.push_back(field_error(model, kSmooth).rms);
    if (errors.size() > 1) orders.push_back(std::log2(errors.end()[-2] / errors.back()));
  }
  testing::Test::RecordProperty("rms_orders", testing::PrintToString(orders));
  for (const double order : orders) EXPECT_GE(order, 2.85);
}

TEST(Slopes, make_refinement_third_order_on_a_sphere) {
  expect_third_order({icosphere(2, 0.03), icosphere(3, 0.03), icosphere(4, 0.03)},
                     icosphere(6, 0.03));
}

TEST(Slopes, make_refinement_third_order_on_a_saddle) {
  expect_third_order({saddle(6), saddle(12), saddle(24)}, saddle(144),
                     [](const Vec3& p) { return Vec3(-p.x() / 0.04, p.y() / 0.04, 1); });
}

TEST(Slopes, half_of_them_reproduces_a_parabola) {
  const Surface fine = plate(24, 24, 0.1, 0.1), coarse = plate(6, 6, 0.1, 0.1);
  const Field parabola = [](const Vec3& p) {
    return 1 + 30 * p.x() * p.x() - 20 * p.y() * p.y() + 10 * p.x() * p.y();
  };
  RefineReport report;
  const FittedCurves curves = rings_at(coarse, parabola);
  const Model model = refine(curves, fine, all(fine), coarse.triangles, {}, &report);
  EXPECT_EQ(report.interpolation.slope_share, 0.5) << "chosen by leaving points out";
  EXPECT_EQ(report.interpolation.points, 45);
  EXPECT_LT(field_error(model, parabola).most, 1e-6);
}

// On a body of radius a the energy of a press to d is Z(c, d); moving the contact point moves a tip
// by (1 - d / a) of that, and the centre of a ball of radius R by (1 + (R - d) / a).
void expect_slopes_of_the_energy(double ball_m) {
  const double body_m = 0.03, radius_m = body_m + ball_m;
  FittedCurves curves = rings_at(icosphere(1, body_m), kSmooth);
  if (ball_m > 0) curves.probe = sphere_spec(ball_m);
  for (Eigen::Index p = 0; p < curves.position.rows(); ++p) {
    const Vec3 u = curves.normal.row(p);
    const double at_half_m =
        radius_m - runtime::kCurvatureDepth * curves.curves.basis[0].knots_m.back();  // (M15c)
    const Mat3 k = (Mat3::Identity() - u * u.transpose()) / at_half_m;
    curves.curves.control[runtime::kCurvature].row(p) << k(0, 0), k(1, 1), k(2, 2), k(0, 1),
        k(0, 2), k(1, 2);
    curves.curves.control[runtime::kSide3].row(p) =
        -7 * curves.curves.control[runtime::kSide2].row(p);
  }
  const Controls slopes = slopes_of(curves);
  const SplineTables t = tabulate(curves.curves.basis[0]);
  const runtime::SplineView view{t.degree, t.pieces, t.knots.data(), t.weights.data(),
                                 t.integrals.data()};
  for (Eigen::Index p = 0; p < slopes.rows(); ++p)
    for (const double d : {0.001, 0.0035, 0.006})
      for (int k = 0; k < 3; ++k) {
        std::vector<double> component;
        for (int j = 0; j < 4; ++j) component.push_back(slopes(p, 3 * j + k));
        const double g2 = curves.curves.control[runtime::kSide2](p, k), g3 = -7 * g2;
        const double moved = 1 + (ball_m - d) / body_m;
        const double wanted = moved * (g2 * d * d + g3 * d * d * d);
        EXPECT_NEAR(runtime::curve_energy(view, component.data(), d), wanted,
                    1e-9 * std::abs(g2) * d * d + 1e-15);
      }
}
TEST(Slopes, are_those_of_the_energy_where_the_normal_turns) { expect_slopes_of_the_energy(0); }
TEST(Slopes, count_how_far_the_centre_of_a_ball_goes) { expect_slopes_of_the_energy(0.008); }

TEST(Slopes, that_say_nothing_are_left_out) {
  const Surface fine = plate(24, 24, 0.1, 0.1), coarse = plate(6, 6, 0.1, 0.1);
  const Field waves = [](const Vec3& p) { return 3 + std::sin(60 * p.x()) * std::cos(50 * p.y()); };
  FittedCurves curves = rings_at(coarse, waves);
  for (const unsigned seed : {1U, 2U, 3U}) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal(0, 60 * 1.5 / kDepth);
    for (double& g : curves.curves.control[runtime::kSide2].reshaped()) g = normal(random);
    RefineReport report;
    const Model model = refine(curves, fine, all(fine), coarse.triangles, {}, &report);
    EXPECT_EQ(report.interpolation.slope_share, 0) << "seed " << seed;
    EXPECT_EQ(report.interpolation.error, report.interpolation.plain_error);
  }
}

TEST(Slopes, leave_curves_that_rise_from_zero) {
  const Surface fine = plate(24, 24, 0.1, 0.1), coarse = plate(6, 6, 0.1, 0.1);
  FittedCurves curves = rings_at(coarse, kSmooth);
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0, 1e7);
  for (const Eigen::Index corner : {0, 6, 42, 48}) {
    curves.status[static_cast<std::size_t>(corner)] = FitStatus::poor;  // counts in no choice
    for (double& g : curves.curves.control[runtime::kSide3].row(corner)) g = normal(random);
  }
  RefineReport report;
  const Model model = refine(curves, fine, all(fine), coarse.triangles, {}, &report);
  EXPECT_EQ(report.interpolation.slope_share, 0.5);
  const auto parts = parts_of(CurveFamily::rings);
  const Controls& control = model.curves.control[0];
  for (Eigen::Index v = 0; v < control.rows(); ++v)
    EXPECT_TRUE(runtime::is_good_part(parts[0], control.row(v).data(),
                                      static_cast<int>(control.cols()), false))
        << "vertex " << v;
}

// Of a cubic, half of the slopes leaves a third difference.
TEST(ExpectedError, with_slopes_is_a_quarter_of_a_parabolas_and_bounds_what_a_cubic_loses) {
  const Surface fine = plate(24, 24, 0.1, 0.1), coarse = plate(6, 6, 0.1, 0.1);
  const auto expected = [&](const Field& field, double* actual) {
    const FittedCurves curves = rings_at(coarse, field);
    RefineReport refined;
    const Model model = refine(curves, fine, all(fine), coarse.triangles, {}, &refined);
    EXPECT_EQ(refined.interpolation.slope_share, 0.5);
    *actual = field_error(model, field).most;
    const auto errors = expected_errors(curves, model, refined, 1e-9);
    return *std::max_element(errors.begin(), errors.end());
  };
  double actual = 0;
  const Field parabola = [](const Vec3& p) { return 1 + 30 * p.x() * p.x(); };
  const FittedCurves curves = without_side_force(rings_at(coarse, parabola));
  RefineReport refined;
  const Model model = refine(curves, fine, all(fine), coarse.triangles, {}, &refined);
  const auto without = expected_errors(curves, model, refined, 1e-9);
  EXPECT_NEAR(expected(parabola, &actual) / *std::max_element(without.begin(), without.end()), 0.25,
              0.05);
  const double bound =
      expected([](const Vec3& p) { return 1 + 300 * p.x() * p.x() * p.y(); }, &actual);
  EXPECT_GT(actual, 5e-5);
  EXPECT_GE(bound, 0.7 * actual);  // errors over forces of 1 to 1.3
  EXPECT_LE(bound, 30 * actual);
}

}  // namespace
}  // namespace palpate::testing_refine
