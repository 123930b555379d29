#include <gtest/gtest.h>

#include "tests/libfit/fit/synthetic.hpp"
#include "tests/support/error_of.hpp"

// Contact point, bias and drift of recordings, fitted with the curves: docs/method-recordings.md,
// section 15.

namespace palpate::test {
namespace {

const Curve kNormal = [](double d) { return d > 0 ? 300 * d + 2e4 * d * d : 0.0; };

// Presses of one point: the tip is `contact_m` deeper than recorded, the sensor adds bias and
// drift.
struct Off {
  double contact_m, bias_N, drift_N;
};
Samples off_presses(const std::vector<Off>& offs, double noise_N, unsigned seed) {
  Recorder rig;
  const int p = rig.add_point(Vec3(0.2, -0.4, 1));
  const Vec3 u = rig.inward(p);
  for (const Off& off : offs) {
    std::vector<Vec3> deflection, force;
    const int rows = 80;
    for (int i = 0; i < rows; ++i) {
      const double depth_m = -0.002 + 0.012 * i / (rows - 1), t = i / (rows - 1.0) - 0.5;
      deflection.push_back((depth_m - off.contact_m) * u);
      force.push_back((kNormal(depth_m) + off.bias_N + off.drift_N * t) * u);
    }
    rig.add(p, ExperimentKind::press, deflection, force);
    rig.samples.recordings.experiment.push_back(rig.samples.experiment.back());
  }
  rig.samples.recordings.contact_deviation_m.assign(offs.size(), 2e-4);
  add_noise(rig.samples, noise_N, seed);
  return rig.samples;
}

FitOptions freeing(bool contact, bool bias, bool drift) {
  FitOptions options = kSeparable;
  options.estimates = {contact, bias, drift};
  return options;
}

TEST(nuisance, bias_and_drift_of_each_recording_are_found_within_their_errors) {
  const std::vector<Off> offs{{0, 0.12, -0.1}, {0, -0.05, 0.15}, {0, 0, 0}};
  const FittedCurves fitted = fit_curves(off_presses(offs, 0.01, 3), freeing(false, true, true));
  ASSERT_EQ(fitted.recordings.experiment, (std::vector<std::int32_t>{0, 1, 2}));
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Off& off = offs[static_cast<std::size_t>(i)];
    EXPECT_NEAR(fitted.recordings.bias_N[i], off.bias_N, 4 * fitted.recordings.bias_deviation_N[i]);
    EXPECT_NEAR(fitted.recordings.drift_N[i], off.drift_N,
                4 * fitted.recordings.drift_deviation_N[i]);
    EXPECT_LT(fitted.recordings.bias_deviation_N[i], 0.01);
    EXPECT_EQ(fitted.recordings.contact_m[i], 0);
    EXPECT_EQ(fitted.recordings.contact_deviation_m[i], 0);
  }
  const double free_error =
      relative_rmse(fitted_curve(fitted, 0, CurveKind::normal), kNormal, 0.01);
  const FittedCurves fixed = fit_curves(off_presses(offs, 0.01, 3), freeing(false, false, false));
  EXPECT_LT(free_error, 0.01);
  EXPECT_GT(relative_rmse(fitted_curve(fixed, 0, CurveKind::normal), kNormal, 0.01),
            2 * free_error);
}

TEST(nuisance, contact_points_of_repeats_are_brought_together) {
  const std::vector<Off> offs{{3e-4, 0, 0}, {-3e-4, 0, 0}, {1e-4, 0, 0}, {-1e-4, 0, 0}};
  const FittedCurves fitted = fit_curves(off_presses(offs, 0.01, 4), freeing(true, false, false));
  for (Eigen::Index i = 0; i < 4; ++i)  // relative to each other; the mean is the prior's
    EXPECT_NEAR(fitted.recordings.contact_m[i] - fitted.recordings.contact_m.mean(),
                offs[static_cast<std::size_t>(i)].contact_m, 3e-5)
        << i;
  EXPECT_LT(fitted.rms_residual_N[0], 0.0185);  // noise of three axes: 0.0173
  const FittedCurves fixed = fit_curves(off_presses(offs, 0.01, 4), freeing(false, false, false));
  EXPECT_GT(fixed.rms_residual_N[0], 0.06);
}

TEST(nuisance, nothing_is_moved_further_than_four_deviations) {
  const FittedCurves fitted =
      fit_curves(off_presses({{3e-3, 0, 0}, {-3e-3, 0, 0}}, 0, 5), freeing(true, false, false));
  for (const double contact_m : fitted.recordings.contact_m)
    EXPECT_LE(std::abs(contact_m), 4 * 2e-4 * (1 + 1e-9));
}

TEST(nuisance, free_contact_points_need_a_deviation) {
  Samples samples = off_presses({{0, 0, 0}}, 0.01, 6);
  samples.recordings.contact_deviation_m.assign(1, 0);
  FitOptions options;
  options.estimates[0] = true;
  EXPECT_EQ(testing_support::fact_of([&] { fit_curves(samples, options); }),
            "asks for contact points, but the samples state no deviation of any");
}

TEST(nuisance, without_anything_unknown_forces_are_replayed_bit_for_bit_as_ever) {
  const fit::Bases bases(
      {CurveBasis{3, {0, 0.5, 1}}, CurveBasis{3, {0, 0.5, 1}}, CurveBasis{3, {0, 1}}});
  const double normal[]{0, 0.2, 0.4, 0.7, 1}, lateral[]{0, 0.3, 0.5, 0.6, 0.9};
  const double limit[]{0, 0.1, 0.2, 0.3};
  const runtime::ControlPointers<double> controls{{normal, lateral, limit}};
  const runtime::Quadric quadric = fit::quadric_of(Vec3::UnitZ(), -0.2 * Mat3::Identity());
  const std::vector<Vec3> way = drag_rows(Vec3::UnitZ(), Vec3::UnitX(), 0.6, 0.8, 20);
  std::vector<runtime::Vec3d> plain(way.size()), shifted(way.size());
  const auto rows = static_cast<int>(way.size());
  runtime::replay_drag<double>(bases.views, controls, quadric, way[0].data(), rows, plain.data());
  const double deeper = 0;
  runtime::replay_drag<double>(bases.views, controls, quadric, {way[0].data(), rows}, &deeper,
                               shifted.data());
  for (std::size_t i = 0; i < way.size(); ++i) {
    EXPECT_EQ(plain[i].x, shifted[i].x) << i;
    EXPECT_EQ(plain[i].z, shifted[i].z) << i;
  }
}

}  // namespace
}  // namespace palpate::test
