#include <gtest/gtest.h>

#include <atomic>
#include <limits>

#include "tests/libfit/fit/synthetic.hpp"
#include "tests/libfit/io/scratch.hpp"

namespace palpate::test {
namespace {

const Curve kNormal = [](double d) { return 300 * d + 2e4 * d * d; };
const Curve kLateral = [](double r) { return 250 * r; };
const Curve kLimit = [](double d) { return 0.4 * kNormal(d); };

void record_all(Recorder& rig, int p) {
  rig.press(p, kNormal, 0.01, 12);
  for (const double depth_m : {0.004, 0.007, 0.01})
    rig.flat_drag(p, kNormal, kLateral, kLimit, depth_m, 0.012, 12, 100 * depth_m);
}

// A body of sound points with some noise.
Recorder sound_body(int points, unsigned seed) {
  Recorder rig;
  for (int i = 0; i < points; ++i)
    record_all(rig, rig.add_point(Vec3(std::sin(i), 1, std::cos(2.0 * i))));
  add_noise(rig.samples, 0.01, seed);
  return rig;
}

void expect_same(const FittedCurves& a, const FittedCurves& b) {
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    EXPECT_EQ(a.curves.basis[kind].knots_m, b.curves.basis[kind].knots_m);
    EXPECT_EQ(a.curves.control[kind], b.curves.control[kind]);
  }
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.message, b.message);
  EXPECT_EQ(a.rms_residual_N, b.rms_residual_N);
  EXPECT_EQ(a.max_residual_N, b.max_residual_N);
}

TEST(fit, results_do_not_depend_on_the_number_of_threads) {
  const Recorder rig = sound_body(12, 5);
  const FittedCurves one = fit_curves(rig.samples, {.family = CurveFamily::separable, .jobs = 1});
  for (const int jobs : {2, 3, 8})
    expect_same(one, fit_curves(rig.samples, {.family = CurveFamily::separable, .jobs = jobs}));
}

TEST(fit, millinewtons_over_micrometres_and_kilonewtons_over_metres_fit_alike) {
  const Recorder rig = sound_body(2, 8);
  const FittedCurves plain = fit_curves(rig.samples, kSeparable);
  for (const double length : {1e-3, 1.0, 1e3})
    for (const double force : {1e-3, 1.0, 1e3}) {
      Samples scaled = rig.samples;
      scaled.deflection *= length;
      scaled.force *= force;
      const FittedCurves fitted = fit_curves(scaled, kSeparable);
      for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
        const Controls& expected = plain.curves.control[kind];
        ASSERT_EQ(fitted.curves.control[kind].cols(), expected.cols());
        EXPECT_LT((fitted.curves.control[kind] / force - expected).cwiseAbs().maxCoeff(),
                  1e-6 * expected.maxCoeff())
            << kCurveNames[kind] << " length " << length << " force " << force;
        EXPECT_NEAR(fitted.curves.basis[kind].knots_m.back(),
                    length * plain.curves.basis[kind].knots_m.back(),
                    1e-9 * length * plain.curves.basis[kind].knots_m.back());
      }
    }
}

TEST(fit, residuals_are_those_of_the_stored_curves_in_the_engine_template) {
  const Recorder rig = sound_body(1, 3);
  const FittedCurves fitted = fit_curves(rig.samples, kSeparable);
  const fit::Bases bases(fitted.curves.basis);
  std::array<Eigen::VectorXd, kCurveKinds> control;
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind)
    control[kind] = fitted.curves.control[kind].row(0);
  double largest = 0, square = 0;
  for (int experiment = 0; experiment < rig.experiments; ++experiment) {
    std::vector<Vec3> rows, force;
    for (Eigen::Index i = 0; i < rig.samples.rows(); ++i)
      if (rig.samples.experiment[static_cast<std::size_t>(i)] == experiment) {
        rows.emplace_back(rig.samples.deflection.row(i));
        force.emplace_back(rig.samples.force.row(i));
      }
    std::vector<runtime::Vec3d> replayed(rows.size());
    runtime::replay_drag<double>(
        bases.views, {{control[0].data(), control[1].data(), control[2].data()}},
        fit::quadric_of(rig.inward(0).normalized(), Mat3::Zero()), rows.front().data(),
        static_cast<int>(rows.size()), replayed.data());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const Vec3 f(replayed[i].x, replayed[i].y, replayed[i].z);
      largest = std::max(largest, (f - force[i]).norm());
      square += (f - force[i]).squaredNorm();
    }
  }
  EXPECT_EQ(fitted.max_residual_N[0], largest);
  EXPECT_NEAR(fitted.rms_residual_N[0], std::sqrt(square / static_cast<double>(rig.samples.rows())),
              1e-15);
}

TEST(fit, outliers_move_curves_little) {
  Recorder rig;
  const int p = rig.add_point(Vec3::UnitY());
  rig.press(p, kNormal, 0.01, 60);
  for (const double depth_m : {0.004, 0.007, 0.01})
    rig.flat_drag(p, kNormal, kLateral, kLimit, depth_m, 0.012, 40, 0);
  add_noise(rig.samples, 0.01, 21);
  for (Eigen::Index i = 5; i < rig.samples.rows(); i += 14) rig.samples.force.row(i) *= 1.8;
  const FittedCurves fitted =
      fit_curves(rig.samples, {.family = CurveFamily::separable, .pieces = {1, 1, 1}});
  EXPECT_LT(relative_rmse(fitted_curve(fitted, 0, CurveKind::normal), kNormal, 0.01), 0.012);
  EXPECT_LT(relative_rmse(fitted_curve(fitted, 0, CurveKind::lateral), kLateral, 0.006), 0.012);
  EXPECT_LT(relative_rmse(fitted_curve(fitted, 0, CurveKind::limit), kLimit, 0.01), 0.012);
}

TEST(fit, better_rows_count_more) {
  Recorder rig;
  const int p = rig.add_point(Vec3::UnitX());
  rig.press(p, kNormal, 0.01, 20);
  rig.press(
      p, [](double d) { return 1.2 * kNormal(d); }, 0.01, 20);
  rig.samples.force_error.head(20).setConstant(0.01);
  rig.samples.force_error.tail(20).setConstant(1.0);
  const FittedCurves fitted = fit_curves(rig.samples, kSeparable);
  EXPECT_LT(relative_rmse(fitted_curve(fitted, 0, CurveKind::normal), kNormal, 0.01), 1e-3);
}

// One bad point in a body of two sound ones; the message it gets.
struct BadPoint {
  FitStatus status;
  std::string message;
};
BadPoint fit_with_bad_point(const std::function<void(Recorder&, int)>& record) {
  Recorder rig;
  record_all(rig, rig.add_point(Vec3::UnitX()));
  record(rig, rig.add_point(Vec3::UnitY()));
  record_all(rig, rig.add_point(Vec3::UnitZ()));
  const FittedCurves fitted = fit_curves(rig.samples, kSeparable);
  for (const Eigen::Index good : {0, 2}) {
    EXPECT_EQ(fitted.status[static_cast<std::size_t>(good)], FitStatus::good)
        << fitted.message[static_cast<std::size_t>(good)];
    EXPECT_LT(relative_rmse(fitted_curve(fitted, good, CurveKind::normal), kNormal, 0.01), 0.01);
  }
  for (const auto& control : fitted.curves.control) EXPECT_TRUE(control.allFinite());
  return {fitted.status[1], fitted.message[1]};
}

struct BadCase {
  const char* name;
  std::function<void(Recorder&, int)> record;
  FitStatus status;
  const char* message;
};

std::function<void(Recorder&, int)> pressed(const Curve& normal, int rows = 12) {
  return [=](Recorder& rig, int p) { rig.press(p, normal, 0.01, rows); };
}

std::function<void(Recorder&, int)> dragged(const Curve& lateral, const Curve& limit) {
  return [=](Recorder& rig, int p) {
    rig.press(p, kNormal, 0.01, 12);
    for (const double depth_m : {0.005, 0.01})
      rig.flat_drag(p, kNormal, lateral, limit, depth_m, 0.012, 12, 0);
  };
}

// Some of its rows are no numbers.
std::function<void(Recorder&, int)> with_nans(int bad_rows) {
  return [=](Recorder& rig, int p) {
    const Eigen::Index first = rig.samples.rows();
    record_all(rig, p);
    for (int i = 0; i < bad_rows; ++i)
      rig.samples.force(first + 2 * i, 1) =
          i % 2 == 0 ? std::nan("") : std::numeric_limits<double>::infinity();
  };
}

double huge(double) { return 1e9; }

TEST(bad_point, is_told_by_name_and_leaves_the_others) {
  const auto one_depth = [](Recorder& rig, int p) {
    for (int i = 0; i < 5; ++i) rig.press(p, kNormal, 0.01, 1);
  };
  const auto below_the_error = [](Recorder& rig, int p) {
    rig.press(
        p, [](double) { return 0.01; }, 0.01, 12);
    rig.samples.force_error.tail(12).setConstant(0.02);
  };
  const auto outside = [](Recorder& rig, int p) { rig.press(p, kNormal, -0.01, 12); };
  const BadCase kCases[] = {
      {"no rows", [](Recorder&, int) {}, FitStatus::failed,
       "no row of any experiment at this point"},
      {"one row gets a line", pressed(kNormal, 1), FitStatus::underdetermined,
       "1 row(s) in contact: the normal curve is a straight line"},
      {"one depth gets a line", one_depth, FitStatus::underdetermined,
       "all rows at one depth: the normal curve is a straight"},
      {"drags that never slip get a limit above what held", dragged(kLateral, huge),
       FitStatus::underdetermined, "no row slips: the limit is "},
      {"drags that slip in every row get the softest line that does", dragged(huge, kLimit),
       FitStatus::underdetermined, "no row sticks: the lateral curve is the softest line"},
      {"many NaNs", with_nans(20), FitStatus::failed, "good rows are not finite numbers"},
      {"few NaNs", with_nans(3), FitStatus::good, ""},
      {"the wrong sign", pressed([](double d) { return -kNormal(d); }), FitStatus::failed,
       "forces point out of the body"},
      {"within the errors", below_the_error, FitStatus::failed,
       "no contact: the largest force is within four force errors"},
      {"no force", pressed([](double) { return 0.0; }), FitStatus::failed, "every force is zero"},
      {"outside", outside, FitStatus::failed, "no row with the probe in the body"}};
  for (const BadCase& bad : kCases) {
    SCOPED_TRACE(bad.name);
    const BadPoint found = fit_with_bad_point(bad.record);
    EXPECT_EQ(found.status, bad.status);
    EXPECT_NE(found.message.find(bad.message), std::string::npos) << found.message;
  }
}

// Every kind of curve is judged by itself.
TEST(pressed_point, is_good_where_its_normal_curve_is_and_the_rest_is_assumed_once) {
  Recorder rig;
  record_all(rig, rig.add_point(Vec3::UnitX()));
  rig.press(rig.add_point(Vec3::UnitY()), kNormal, 0.01, 12);
  rig.press(rig.add_point(Vec3::UnitZ()), kNormal, 0.01, 1);
  FitReport report;
  const FittedCurves fitted = fit_curves(rig.samples, kSeparable, {}, &report);
  EXPECT_EQ(fitted.status[1], FitStatus::good) << fitted.message[1];
  EXPECT_EQ(fitted.message[1], "");
  EXPECT_EQ(fitted.status[2], FitStatus::underdetermined);
  EXPECT_EQ(fitted.message[2], "1 row(s) in contact: the normal curve is a straight line");
  EXPECT_EQ(
      report.assumed,
      "2 of 3 points were not dragged: there the lateral stiffness is 0.667 of the normal one "
      "and the limit of friction 0.3 of the normal force, or just above what held in a press");
  const double normal_N = fitted_curve(fitted, 1, CurveKind::normal)(0.01);
  EXPECT_NEAR(fitted_curve(fitted, 1, CurveKind::limit)(0.01), 0.3 * normal_N, 1e-3 * normal_N);
  EXPECT_NEAR(fitted_curve(fitted, 1, CurveKind::lateral)(0.003), 0.2 * normal_N, 1e-3 * normal_N);
}

// The separable law would have one lateral stiffness at all depths, which is 64 times as much here.
TEST(family, without_drags_is_rings_whose_lateral_stiffness_goes_with_the_normal_one) {
  Recorder rig;
  rig.press(
      rig.add_point(Vec3::UnitY()), [](double d) { return 3e8 * std::pow(d, 4); }, 0.01, 24);
  FitReport report;
  const FittedCurves fitted = fit_curves(rig.samples, {}, {}, &report);
  EXPECT_EQ(report.family.reason, "no drags");
  EXPECT_NEAR(NodeForces(fitted.curves).lateral_slope_N_m(0, 0.0025), 12.5, 0.5);
}

TEST(bad_point, whose_forces_fall_with_depth_is_marked) {
  const BadPoint bad = fit_with_bad_point(pressed([](double d) { return 5 * (1.05 - d / 0.01); }));
  EXPECT_NE(bad.status, FitStatus::good);
  EXPECT_NE(bad.message.find("residual is"), std::string::npos) << bad.message;
}

TEST(fit, rows_not_good_are_left_out_and_a_drag_ends_at_the_first) {
  Recorder rig;
  record_all(rig, rig.add_point(Vec3::UnitX()));
  // A press row and the sixth row of the first drag did not converge and hold nonsense.
  for (const std::size_t bad : {std::size_t{3}, std::size_t{17}}) {
    rig.samples.status[bad] = RowStatus::not_converged;
    rig.samples.force.row(static_cast<Eigen::Index>(bad)).setConstant(77);
  }
  for (Eigen::Index i = 18; i < 25; ++i) rig.samples.force.row(i).setConstant(-55);
  FitReport report;
  const FittedCurves fitted = fit_curves(rig.samples, kSeparable, {}, &report);
  EXPECT_EQ(report.rows.not_good, 2u);
  EXPECT_EQ(report.rows.cut, 7u);
  EXPECT_EQ(report.rows.all, report.rows.used + 9);
  EXPECT_EQ(fitted.status[0], FitStatus::good) << fitted.message[0];
  EXPECT_LT(fitted.max_residual_N[0], 0.05);
}

TEST(fit, a_body_without_any_usable_row_still_answers) {
  Recorder rig;
  rig.add_point(Vec3::UnitX());
  FitReport report;
  const FittedCurves fitted = fit_curves(rig.samples, kSeparable, {}, &report);
  EXPECT_EQ(fitted.status[0], FitStatus::failed);
  EXPECT_EQ(report.points.failed, 1u);
  EXPECT_EQ(fit_curves(Samples{}).curves.points(), 0);
}

TEST(fit, worst_points_are_named_with_place_and_reason) {
  Recorder rig;
  for (int i = 0; i < 4; ++i) record_all(rig, rig.add_point(Vec3::UnitX()));
  const Eigen::Index rows = rig.samples.rows() / 4;
  rig.samples.force.row(2 * rows + 11) *= 3;  // deepest press row of point 2
  FitReport report;
  const FittedCurves fitted = fit_curves(rig.samples, kSeparable, {}, &report);
  ASSERT_EQ(report.worst.size(), 3u);
  EXPECT_EQ(report.worst[0].point, 2);
  EXPECT_EQ(report.worst[0].position, Vec3(fitted.position.row(2)));
  EXPECT_NE(report.worst[0].reason.find("worst at row 11 of experiment 8"), std::string::npos)
      << report.worst[0].reason;
  EXPECT_EQ(fitted.status[2], FitStatus::poor) << fitted.message[2];
}

TEST(fit, stopping_leaves_the_rest_failed_by_name) {
  const Recorder rig = sound_body(6, 1);
  std::atomic<int> done = 0;
  const Progress progress{[&](std::size_t, std::size_t, const std::string&) { ++done; },
                          [&] { return done >= 2; }};
  FitReport report;
  const FittedCurves fitted =
      fit_curves(rig.samples, {.family = CurveFamily::separable, .jobs = 1}, progress, &report);
  EXPECT_TRUE(report.is_stopped);
  EXPECT_EQ(report.points.failed, 4u);
  EXPECT_EQ(fitted.message[5], "stopped before this point was fitted");
}

TEST(fit, refuses_options_and_samples_that_make_no_sense) {
  const Recorder rig = sound_body(1, 1);
  const auto refusal = [](const Samples& samples, const FitOptions& options = kSeparable) {
    return testing_io::error_of([&] { fit_curves(samples, options); });
  };
  EXPECT_EQ(refusal(rig.samples, {.degree = 5}), "fit option degree: is not 1 to 4");
  EXPECT_EQ(refusal(rig.samples, {.tolerance = -1}), "fit option tolerance: is not in [0, 1)");
  EXPECT_EQ(refusal(rig.samples, {.jobs = -1}), "fit option jobs: is negative");
  Samples broken = rig.samples;
  broken.point[4] = 9;
  EXPECT_EQ(refusal(broken), "samples: row 4 names test point 9 of 1");
  broken = rig.samples;
  broken.kind[4] = ExperimentKind::drag;
  EXPECT_EQ(refusal(broken), "samples: experiment 0 mixes test points or kinds");
  broken = rig.samples;
  broken.step.pop_back();
  EXPECT_EQ(refusal(broken), "samples: row arrays differ in length");
  broken = rig.samples;
  broken.point_normal.row(0) *= 2;
  EXPECT_EQ(refusal(broken), "samples: test point 0 has no finite position and unit normal");
}

}  // namespace
}  // namespace palpate::test
