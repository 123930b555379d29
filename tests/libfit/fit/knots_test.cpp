#include <gtest/gtest.h>

#include "libfit/fit/basis/place_knots.hpp"
#include "libfit/fit/rows/curve_rows.hpp"
#include "tests/libfit/fit/synthetic.hpp"

// Knots identified from rows: docs/method.md, section 3.

namespace palpate::test {
namespace {

using fit::KnotResiduals;
using fit::PointEvidence;

CurveBasis even(int degree, int pieces) {
  CurveBasis basis{degree, {}};
  for (int i = 0; i <= pieces; ++i) basis.knots_m.push_back(double(i) / pieces);
  return basis;
}

PointEvidence evidence(const Curve& truth, const std::vector<double>& at, double noise,
                       std::mt19937& random) {
  std::normal_distribution<double> scatter(0, noise > 0 ? noise : 1);
  PointEvidence point;
  for (const double x : at)
    point.rows.push_back({x, truth(x) + (noise > 0 ? scatter(random) : 0), 1, 0});
  fit::group_by_abscissa(point.rows, 1, 1e-3);
  for (const fit::CurveRow& row : point.rows) point.largest = std::max(point.largest, row.f);
  return point;
}

std::vector<double> equal_steps(int rows) {
  std::vector<double> at;
  for (int i = 1; i <= rows; ++i) at.push_back(double(i) / rows);
  return at;
}

// Curves with a bend of each point's own at one place.
std::vector<PointEvidence> bent_body(int points, int rows, double knee, double noise,
                                     unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> draw(0.5, 2);
  std::vector<PointEvidence> body;
  for (int p = 0; p < points; ++p) {
    const double k = draw(random), c = 4 * draw(random);
    body.push_back(evidence([=](double x) { return k * x + c * std::max(0.0, x - knee); },
                            equal_steps(rows), noise * (k + c * (1 - knee)), random));
  }
  return body;
}

double nearest(const CurveBasis& basis, double x) {
  double best = 1;
  for (const double knot : basis.knots_m) best = std::min(best, std::abs(knot - x));
  return best;
}

TEST(knots, log_ratios_give_their_knots_back_and_any_ratios_give_knots_apart) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> draw(0, seed % 2 == 0 ? 1 : 300);
    const int pieces = 2 + static_cast<int>(seed) % 6;
    const double range = 0.3 * seed, least = 0.5 * range / pieces;
    Eigen::VectorXd ratios(pieces - 1);
    for (double& r : ratios) r = draw(random);
    const auto knots = fit::knots_from(ratios, range, least);
    EXPECT_EQ(knots.front(), 0.0);
    EXPECT_EQ(knots.back(), range);
    for (std::size_t i = 1; i < knots.size(); ++i)
      EXPECT_GE(knots[i] - knots[i - 1], least * (1 - 1e-9)) << "seed " << seed;
    if (seed % 2 == 0) {
      EXPECT_LT((fit::log_ratios(knots, least) - ratios).cwiseAbs().maxCoeff(), 1e-9)
          << "seed " << seed;
    }
  }
}

TEST(knots, their_jacobian_is_the_derivative_by_log_ratios) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> draw(0, 2);
    Eigen::VectorXd ratios(5);
    for (double& r : ratios) r = draw(random);
    const Eigen::MatrixXd J = fit::knots_jacobian(ratios, 1.2, 0.03);
    for (Eigen::Index j = 0; j < 5; ++j) {
      Eigen::VectorXd back = ratios, on = ratios;
      back[j] -= 1e-5, on[j] += 1e-5;
      const auto a = fit::knots_from(back, 1.2, 0.03), b = fit::knots_from(on, 1.2, 0.03);
      for (std::size_t i = 0; i < 5; ++i)
        EXPECT_NEAR(J(static_cast<Eigen::Index>(i), j), (b[i + 1] - a[i + 1]) / 2e-5, 1e-9)
            << "seed " << seed;
    }
  }
}

// Largest difference of J^T r from central differences of |r|^2 / 2, over the largest of either.
double gradient_error(const KnotResiduals& function, const Eigen::VectorXd& ratios) {
  Eigen::VectorXd left(function.NumResiduals());
  Eigen::MatrixXd J(left.size(), ratios.size());
  EXPECT_TRUE(function(ratios.data(), left.data(), J.data()));
  const Eigen::VectorXd gradient = J.transpose() * left;
  Eigen::VectorXd numeric(ratios.size());
  for (Eigen::Index k = 0; k < ratios.size(); ++k) {
    const double step = 1e-5;
    Eigen::VectorXd other = ratios;
    double cost[2];
    for (const int side : {0, 1}) {
      other[k] = ratios[k] + (side == 0 ? -step : step);
      function(other.data(), left.data(), nullptr);
      cost[side] = 0.5 * left.squaredNorm();
    }
    numeric[k] = (cost[1] - cost[0]) / (2 * step);
  }
  return (gradient - numeric).cwiseAbs().maxCoeff() / numeric.cwiseAbs().maxCoeff();
}

TEST(knots, gradient_of_the_projected_squares_is_their_derivative) {
  for (int degree = 2; degree <= 4; ++degree)
    for (unsigned seed = 1; seed <= 6; ++seed) {
      std::mt19937 random(seed);
      std::normal_distribution<double> draw(0, 0.7);
      // The toe holds increments at their bound.
      std::vector<PointEvidence> body = bent_body(3, 40, 0.45, 0.02, seed);
      body.push_back(
          evidence([](double x) { return std::max(0.0, x - 0.3); }, equal_steps(33), 0, random));
      const KnotResiduals function(body, even(degree, 6), 4, 0.05, FitLoss::huber);
      Eigen::VectorXd ratios(3);
      for (double& r : ratios) r = draw(random);
      EXPECT_LT(gradient_error(function, ratios), 2e-4) << "degree " << degree << " seed " << seed;
    }
}

TEST(knots, gradient_holds_where_a_knot_is_a_row_nearly_meets_another_or_has_no_rows_beside_it) {
  std::mt19937 random(3);
  const std::vector<PointEvidence> body = bent_body(3, 40, 0.45, 0.02, 3);
  const KnotResiduals function(body, even(3, 6), 3, 0.05, FitLoss::huber);
  EXPECT_LT(gradient_error(function, fit::log_ratios({0, 0.25, 0.5, 1}, 0.05)), 2e-4) << "a row";
  EXPECT_LT(gradient_error(function, fit::log_ratios({0, 0.4, 0.4501, 1}, 0.05)), 2e-4)
      << "as near as may be";
  std::vector<double> gap;
  for (const double x : equal_steps(40))
    if (x < 0.3 || x > 0.6) gap.push_back(x);
  const std::vector<PointEvidence> holed{
      evidence([](double x) { return x + x * x * x; }, gap, 0.01, random)};
  const KnotResiduals few(holed, even(3, 6), 3, 0.05, FitLoss::squared);
  EXPECT_LT(gradient_error(few, fit::log_ratios({0, 0.35, 0.55, 1}, 0.05)), 2e-4) << "no rows";
}

TEST(knots, of_the_truth_are_found_to_a_thousandth_of_the_range) {
  for (int degree = 1; degree <= 4; ++degree)
    for (unsigned seed = 1; seed <= 5; ++seed) {
      std::mt19937 random(seed);
      std::uniform_real_distribution<double> draw(0.2, 2);
      const CurveBasis truth{degree, {0, 0.37, 0.7, 1}};
      std::vector<PointEvidence> body;
      for (int p = 0; p < 6; ++p) {
        Eigen::VectorXd increments(truth.size() - 1);
        for (double& a : increments) a = draw(random);
        const Eigen::VectorXd control = fit::controls_of(increments);
        body.push_back(evidence(
            [&, tables = tabulate(truth)](double x) {
              return runtime::curve_value(fit::view(tables), control.data(), x);
            },
            equal_steps(60), 0, random));
      }
      const auto found = fit::place_knots(body, even(degree, 3), even(degree, 8), FitLoss::huber);
      for (const double knot : {0.37, 0.7})
        EXPECT_LT(nearest(found.basis, knot), 1e-3)
            << "degree " << degree << " seed " << seed << ": " << found.basis.knots_m[1] << ' '
            << found.basis.knots_m[2];
    }
}

TEST(knots, meet_the_kink_of_noisy_polylines) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const auto body = bent_body(12, 40, 0.62, 0.01, seed);
    const auto found = fit::place_knots(body, even(1, 2), even(1, 8), FitLoss::huber);
    EXPECT_NEAR(found.basis.knots_m[1], 0.62, 0.01) << "seed " << seed;
  }
}

TEST(knots, near_a_kink_that_cubics_cannot_have_predict_held_out_rows_better) {
  for (const double knee : {0.3, 0.62, 0.81})
    for (unsigned seed = 1; seed <= 3; ++seed) {
      const auto body = bent_body(8, 50, knee, 0.002, seed);
      const auto found =
          fit::identified_candidate(body, {}, {even(3, 4)}, even(3, 8), FitLoss::huber);
      ASSERT_TRUE(found) << "knee " << knee << " seed " << seed;
      EXPECT_LT(nearest(found->basis, knee), 0.1) << "knee " << knee << " seed " << seed;
      const auto by_rule = fit::judge(body, {}, even(3, 4), KnotPlacement::even, FitLoss::huber);
      EXPECT_TRUE(is_clearly_better(*found, by_rule)) << "knee " << knee << " seed " << seed;
      EXPECT_LT(found->evidence.heldout_error, 0.8 * by_rule.evidence.heldout_error);
    }
}

TEST(knots, stay_apart_from_any_start_and_with_any_rows) {
  std::mt19937 random(5);
  const auto soft = [](double x) { return x * x; };
  const std::vector<double> gap{0.05, 0.1, 0.15, 0.2, 0.25, 0.9, 0.95, 1};
  const std::vector<PointEvidence> bodies[] = {
      {evidence(soft, equal_steps(60), 0.01, random)},             // one point
      {evidence(soft, gap, 0.01, random)},                         // no rows for most of it
      {evidence(soft, {0.5, 1}, 0, random)},                       // fewer rows than increments
      {evidence(soft, std::vector<double>(20, 1.0), 0, random)}};  // one abscissa
  for (const auto& body : bodies)
    for (const CurveBasis& start : {even(3, 5), CurveBasis{3, {0, 1e-7, 2e-7, 3e-7, 0.5, 1}},
                                    CurveBasis{3, {0, 0.5, 0.5000001, 0.5000002, 0.999999, 1}}}) {
      const auto found = fit::place_knots(body, start, even(3, 8), FitLoss::huber);
      const double least = fit::min_spacing(body, 1, 5);
      ASSERT_EQ(found.basis.pieces(), 5);
      EXPECT_GT(least, 0);
      for (std::size_t i = 1; i <= 5; ++i)
        EXPECT_GE(found.basis.knots_m[i] - found.basis.knots_m[i - 1], 0.999 * least);
      EXPECT_LE(found.rms, found.rms_start * (1 + 1e-9));
    }
}

// A body of presses whose force bends at one depth.
Recorder pressed_body(double knee_m, double noise_N, unsigned seed, int rows = 50) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> draw(0.5, 2);
  Recorder rig;
  for (int p = 0; p < 8; ++p) {
    const double k = 100 * draw(random), c = 800 * draw(random);
    rig.press(
        rig.add_point(Vec3::UnitZ()),
        [=](double d) { return k * d + c * std::max(0.0, d - knee_m); }, 0.01, rows);
  }
  add_noise(rig.samples, noise_N, seed);
  return rig;
}

FitOptions presses(double tolerance, int jobs = 0) {
  FitOptions options{.family = CurveFamily::separable, .tolerance = tolerance};
  options.jobs = jobs;
  return options;
}

TEST(knots, of_a_body_with_a_kink_are_identified_by_the_fit_whatever_the_threads) {
  const Recorder rig = pressed_body(0.0062, 0.003, 4);
  FitReport report;
  const FittedCurves fitted = fit_curves(rig.samples, presses(0.005, 1), {}, &report);
  CurveBasis basis = fitted.curves.basis[0];
  EXPECT_NE(report.kind[0].reason.find("identified"), std::string::npos) << report.kind[0].reason;
  EXPECT_LT(nearest(basis, 0.0062), 0.0004);
  for (const int jobs : {2, 5}) {
    const FittedCurves other = fit_curves(rig.samples, presses(0.005, jobs));
    EXPECT_EQ(other.curves.basis[0].knots_m, basis.knots_m);
    EXPECT_EQ(other.curves.control[0], fitted.curves.control[0]);
  }
}

TEST(knots, of_smooth_bodies_stay_where_rules_place_them) {
  for (const double power : {1.0, 1.5, 2.0})
    for (unsigned seed = 1; seed <= 4; ++seed) {
      Recorder rig;
      for (int p = 0; p < 6; ++p)
        rig.press(
            rig.add_point(Vec3::UnitZ()),
            [&](double d) { return (1 + 0.1 * p) * std::pow(d / 0.01, power); }, 0.01, 40);
      add_noise(rig.samples, 0.01, seed);
      FitReport report;
      const FittedCurves fitted = fit_curves(rig.samples, presses(0), {}, &report);
      EXPECT_EQ(report.kind[0].reason.find("identified"), std::string::npos)
          << "power " << power << " seed " << seed << ": " << report.kind[0].reason;
      EXPECT_LE(fitted.curves.basis[0].pieces(), power == 1.0 ? 1 : 3) << "seed " << seed;
    }
}

TEST(basis, follows_a_body_that_stiffens_at_its_end_although_its_rows_count_less_there) {
  // As a silicone does over its last two of twenty millimetres. Clipped as outliers, these rows
  // left bases of one or two pieces, up to 70 % off.
  for (const double strength_N : {60, 120, 240})
    for (const double power : {2.0, 3.0})
      for (const double from_m : {0.016, 0.0175}) {
        Recorder rig;
        rig.press(
            rig.add_point(Vec3::UnitZ()),
            [=](double d) {
              const double end = std::max(0.0, (d - from_m) / (0.02 - from_m));
              return 3e3 * d + 1e5 * d * d + strength_N * std::pow(end, power);
            },
            0.02, 40);
        for (Eigen::Index i = 0; i < rig.samples.rows(); ++i)
          rig.samples.force_error[i] = 0.05 * rig.samples.force.row(i).norm();
        FitReport report;
        fit_curves(rig.samples, presses(0.02), {}, &report);
        EXPECT_LT(report.error.max, 0.04) << strength_N << " N, power " << power << " from "
                                          << from_m << " m: " << report.kind[0].reason;
      }
}

TEST(basis, of_a_line_with_single_outliers_has_one_piece) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Recorder rig;
    for (int p = 0; p < 4; ++p)
      rig.press(
          rig.add_point(Vec3::UnitZ()), [](double d) { return 300 * d; }, 0.01, 60);
    add_noise(rig.samples, 0.01, seed);
    for (Eigen::Index i = 7; i < rig.samples.rows(); i += 19) rig.samples.force.row(i) *= 1.5;
    FitReport report;
    const FittedCurves fitted = fit_curves(rig.samples, presses(0.02), {}, &report);
    EXPECT_EQ(fitted.curves.basis[0].pieces(), 1) << "seed " << seed << report.kind[0].reason;
  }
}

// Curves that a basis of one degree holds exactly get that degree, and no more of it than they
// need.
TEST(degree, is_that_of_the_fewest_control_values) {
  for (const int power : {1, 2, 3}) {
    const Curve normal = [power](double d) { return 3 * std::pow(d / 0.01, power); };
    Recorder rig;
    for (int p = 0; p < 3; ++p) rig.press(rig.add_point(Vec3(0.1 * p, 0, 1)), normal, 0.01, 40);
    add_noise(rig.samples, 0.002, 7);
    FitReport report;
    const FittedCurves fitted = fit_curves(rig.samples, {.degree = 0}, {}, &report);
    EXPECT_EQ(fitted.curves.basis[0].degree, power) << report.degree_reason;
    EXPECT_EQ(fitted.curves.basis[0].pieces(), 1) << report.degree_reason;
    EXPECT_LT(relative_rmse(fitted_curve(fitted, 0, CurveKind::normal), normal, 0.01), 0.002);
  }
}

TEST(degree, one_is_not_taken_where_it_would_bend_at_knots) {
  const Curve normal = [](double d) { return 400 * std::max(0.2 * d, d - 0.004); };  // a kink
  Recorder rig;
  rig.press(rig.add_point(Vec3(0, 0, 1)), normal, 0.01, 60);
  const FittedCurves fitted = fit_curves(rig.samples, {.degree = 0});
  EXPECT_GT(fitted.curves.basis[0].degree, 1);
}

}  // namespace
}  // namespace palpate::test
