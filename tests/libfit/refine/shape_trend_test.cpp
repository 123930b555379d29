// Forces that follow the gap under the tool (M12g).

#include "libfit/refine/interpolation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

#include "libfit/refine/next_points.hpp"
#include "tests/libfit/refine/blending.hpp"

namespace palpate::testing_refine {
namespace {

constexpr double kSide_m = 0.12, kHeight_m = 0.002, kWave_1_m = 130;

double height_m(const Vec3& p) {
  return kHeight_m * std::sin(kWave_1_m * p.x()) * std::sin(kWave_1_m * p.y());
}
Surface wavy(int cells) {
  return sheet(cells, cells, [](double u, double v) {
    Vec3 p(u * kSide_m, v * kSide_m, 0);
    p.z() = height_m(p);
    return p;
  });
}
constexpr double kBall_m = 0.008;
const RefineOptions kWithBall{.tool = runtime::ball_indenter(kBall_m)};

// Curves at the coarse sheet's vertices that follow the gap under a ball at each compared depth,
// and what they are at all vertices at the first of them.
struct Followed {
  Surface fine = wavy(60), coarse = wavy(10);
  FittedCurves curves;
  Field force;
  explicit Followed(double share = kGapShare) {
    const FittedCurves on_fine = curves_at(fine, [](const Vec3&) { return 1; });
    const Controls gap = gap_forces(on_fine, fine, vertex_normals(fine), all(fine), {},
                                    runtime::ball_indenter(kBall_m))
                             .force.at_vertex;
    const auto force_at = [=, most = gap.maxCoeff()](Eigen::Index v, int depth) {
      return 3 * std::exp(share * (gap(v, depth) - most));
    };
    force = [=](const Vec3& p) {
      const auto i = std::lround(60 * p.x() / kSide_m), j = std::lround(60 * p.y() / kSide_m);
      return force_at(61 * i + j, 0);
    };
    curves = curves_at(coarse, force);
    const double range_m = curves.curves.basis[0].knots_m.back();
    for (const auto kind : {CurveKind::normal, CurveKind::limit}) {
      CurveBasis& basis = curves.curves.basis[static_cast<std::size_t>(kind)];
      Controls& control = curves.curves.control[static_cast<std::size_t>(kind)];
      basis = {1, {0}};
      control.setZero(121, kComparedDepths + 1);
      for (int k = 1; k <= kComparedDepths; ++k) {
        basis.knots_m.push_back(range_m * k / kComparedDepths);
        for (int i = 0; i <= 10; ++i)
          for (int j = 0; j <= 10; ++j)
            control(11 * i + j, k) = force_at(6 * i * 61 + 6 * j, k - 1);
      }
    }
    for (int i = 0; i <= 10; ++i)  // pressed along the normals of what is pressed
      for (int j = 0; j <= 10; ++j)
        curves.normal.row(11 * i + j) = on_fine.normal.row(6 * i * 61 + 6 * j);
  }
};

TEST(ShapeTrend, a_force_that_follows_the_gap_is_interpolated_ten_times_better) {
  const Followed of;
  RefineReport report;
  const FieldError with = field_error(
      refine(of.curves, of.fine, all(of.fine), of.coarse.triangles, kWithBall, &report), of.force);
  EXPECT_TRUE(report.interpolation.follows_gap) << "chosen by leaving points out";
  EXPECT_LT(report.interpolation.gap_error, 0.1 * report.interpolation.plain_error);
  const FieldError without =
      field_error(refine(of.curves, of.fine, all(of.fine), of.coarse.triangles), of.force);
  EXPECT_LT(10 * with.rms, without.rms);
}

TEST(ShapeTrend, is_used_where_too_few_points_could_be_left_out_to_tell) {
  const Followed of;
  RefineReport report;
  const Surface three = wavy(1);
  refine(curves_at(three, of.force), of.fine, all(of.fine), three.triangles, kWithBall, &report);
  EXPECT_EQ(report.interpolation.points, 0);
  EXPECT_TRUE(report.interpolation.follows_gap);
}

TEST(ShapeTrend, measured_points_do_not_follow_a_surface_that_is_not_sure) {
  const Followed of;
  RefineOptions options = kWithBall;
  options.is_measured = true;
  RefineReport report;
  refine(of.curves, of.fine, all(of.fine), of.coarse.triangles, options, &report);
  EXPECT_FALSE(report.interpolation.follows_gap);
}

TEST(ShapeTrend, a_force_that_does_not_follow_gap_is_left_alone_to_the_bit) {
  const Surface fine = wavy(60), coarse = wavy(10);
  for (const unsigned seed : {1U, 2U, 3U}) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> phase(0, 6);
    const double a = phase(random), b = phase(random);
    const Field force = [=](const Vec3& p) {
      return 3 + std::sin(40 * p.x() + a) + std::cos(35 * p.y() + b);
    };
    const FittedCurves curves = curves_at(coarse, force);
    RefineReport report;
    const Model model = refine(curves, fine, all(fine), coarse.triangles, kWithBall, &report);
    EXPECT_FALSE(report.interpolation.follows_gap) << "seed " << seed;
    EXPECT_EQ(model.curves.control[0],
              refine(curves, fine, all(fine), coarse.triangles).curves.control[0]);
  }
}

TEST(ShapeTrend, placement_expects_what_is_left_of_the_force_over_the_gaps) {
  const Followed of;
  const auto expected_sum = [&](bool follows_gap) {
    RefineReport refined;
    const Model model = refine(of.curves, of.fine, all(of.fine), of.coarse.triangles,
                               follows_gap ? kWithBall : RefineOptions(), &refined);
    EXPECT_EQ(refined.interpolation.follows_gap, follows_gap);
    const auto errors = expected_errors(of.curves, model, refined, 1e-9);
    return std::accumulate(errors.begin(), errors.end(), 0.0);
  };
  EXPECT_LT(2 * expected_sum(true), expected_sum(false));
}

// One press in a groove must not decide for a whole body.
TEST(ShapeTrend, a_poor_point_speaks_for_its_own_place_alone) {
  constexpr Eigen::Index kPoor = 5 * 11 + 5, kItsVertex = 6 * 5 * 61 + 6 * 5;
  const auto refined = [&](float factor, FitStatus status) {
    Followed of;
    of.curves.curves.control[0].row(kPoor) *= factor;
    of.curves.status[kPoor] = status;
    RefineReport report;
    const Model model =
        refine(of.curves, of.fine, all(of.fine), of.coarse.triangles, kWithBall, &report);
    return std::pair(model.curves.control[0](kItsVertex, 1), report);
  };
  const auto [trusted_N, misled] = refined(16, FitStatus::good);
  const auto [kept_N, report] = refined(16, FitStatus::poor);
  const auto [sound_N, without] = refined(1, FitStatus::poor);
  EXPECT_TRUE(report.interpolation.follows_gap);
  EXPECT_EQ(report.interpolation.points, misled.interpolation.points - 1);
  EXPECT_GT(misled.interpolation.gap_error, 10 * without.interpolation.gap_error);
  EXPECT_EQ(report.interpolation.gap_error, without.interpolation.gap_error);
  EXPECT_EQ(kept_N, trusted_N) << "it stays in the model";
  EXPECT_EQ(kept_N, 16 * sound_N);
}

TEST(ShapeTrend, keeps_curves_at_test_points_and_curves_that_rise) {
  Followed of;
  const Model model = refine(of.curves, of.fine, all(of.fine), of.coarse.triangles, kWithBall);
  for (int i = 0; i <= 10; ++i)
    for (int j = 0; j <= 10; ++j) {
      const Eigen::RowVectorXd own = of.curves.curves.control[0].row(i * 11 + j),
                               found = model.curves.control[0].row(6 * i * 61 + 6 * j);
      EXPECT_LT((own - found).norm(), 1e-6 * own.norm()) << "point " << i << ", " << j;
    }
  for (const auto& row : model.curves.control[0].rowwise())
    for (Eigen::Index k = 1; k < row.size(); ++k) EXPECT_GE(row[k], row[k - 1]);
}

}  // namespace
}  // namespace palpate::testing_refine
