#include <gtest/gtest.h>

#include <cstdio>
#include <numbers>

#include "libfit/core/error.hpp"
#include "libfit/fit/spline/curve_band.hpp"
#include "tests/libfit/fit/synthetic.hpp"

// Smoothing over neighbouring test points: docs/method.md, section 16.

namespace palpate::test {
namespace {

constexpr double kDepth = 0.01, kSpacing = 0.01;

Curve normal_of(double k) {
  return [k](double d) { return k * d * (1 + 60 * d); };
}

/// Stiffness [N/m] by place.
using Stiffness = std::function<double(const Vec3&)>;

double smooth_stiffness(const Vec3& at) {
  return 300 * (1 + 0.35 * std::sin(45 * at[0]) * std::cos(35 * at[1]));
}

// A flat body of side x side points, each pressed once.
struct FlatBody {
  Recorder rig;
  std::vector<double> k;

  void add(const Vec3& at, const Vec3& inward, double stiffness, int steps = 20) {
    const int p = rig.add_point(inward);
    rig.samples.point_position.row(p) = at;
    k.push_back(stiffness);
    rig.press(p, normal_of(stiffness), kDepth, steps);
  }
};
FlatBody flat_body(int side, const Stiffness& stiffness, double noise_N, unsigned seed) {
  FlatBody body;
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      const Vec3 at(kSpacing * i, kSpacing * j, 0);
      body.add(at, -Vec3::UnitZ(), stiffness(at));
    }
  if (noise_N > 0) add_noise(body.rig.samples, noise_N, seed);
  return body;
}

FitOptions with_smoothing(std::optional<double> strength) {
  FitOptions options;
  options.family = CurveFamily::separable;
  options.smoothing = strength;
  return options;
}

struct Errors {
  double rmse = 0, coverage = 0, largest_in_deviations = 0;
};
// Over all points: rms of full-scale errors, share of abscissae within bands of 90 %.
Errors errors_of(const FittedCurves& fitted, const std::vector<double>& k) {
  Errors out;
  const SplineTables tables = tabulate(fitted.curves.basis[0]);
  double square = 0, inside = 0, count = 0;
  for (std::size_t p = 0; p < k.size(); ++p) {
    const auto at = static_cast<Eigen::Index>(p);
    const Curve truth = normal_of(k[p]), curve = fitted_curve(fitted, at, CurveKind::normal);
    square += std::pow(full_scale_rmse(curve, truth, kDepth), 2);
    for (int i = 0; i < 10; ++i) {
      const double x = kDepth * (i + 0.5) / 10;
      const double deviation =
          fit::curve_deviation(fit::view(tables), fitted.covariance[0].row(at), x);
      inside += std::abs(curve(x) - truth(x)) <= fit::kBand90 * deviation, ++count;
    }
  }
  out.rmse = std::sqrt(square / static_cast<double>(k.size()));
  out.coverage = inside / count;
  return out;
}

void expect_admissible(const FittedCurves& fitted) {
  for (const Controls& control : fitted.curves.control)
    for (Eigen::Index p = 0; p < control.rows(); ++p) {
      EXPECT_EQ(control(p, 0), 0);
      for (Eigen::Index j = 1; j < control.cols(); ++j) EXPECT_GE(control(p, j), control(p, j - 1));
    }
}

void expect_same_curves(const FittedCurves& a, const FittedCurves& b) {
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    EXPECT_EQ(a.curves.control[kind], b.curves.control[kind]);
    EXPECT_TRUE((a.covariance[kind].array() == b.covariance[kind].array() ||
                 a.covariance[kind].array().isNaN())
                    .all());
  }
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.rms_residual_N, b.rms_residual_N);
}

TEST(smoothing, of_noisy_presses_over_a_smooth_body_lowers_the_error_and_keeps_coverage) {
  double own = 0, smooth = 0, coverage = 0;
  const int trials = 6;
  for (int trial = 0; trial < trials; ++trial) {
    const unsigned seed = 300 + static_cast<unsigned>(trial);
    const FlatBody body = flat_body(10, smooth_stiffness, 0.25, seed);
    FitReport report;
    const Errors before = errors_of(fit_curves(body.rig.samples, with_smoothing(0)), body.k);
    const FittedCurves fitted =
        fit_curves(body.rig.samples, with_smoothing(std::nullopt), {}, &report);
    const Errors after = errors_of(fitted, body.k);
    expect_admissible(fitted);
    std::printf(
        "  seed %u: strength %g, gain %.2f +- %.2f, moved %.2f (most %.2f), rmse %.2f %% "
        "-> %.2f %%, coverage %.1f %% -> %.1f %%\n",
        seed, report.smoothing[0].strength, report.smoothing[0].gain,
        report.smoothing[0].gain_error, report.smoothing[0].median_move,
        report.smoothing[0].largest_move, 100 * before.rmse, 100 * after.rmse,
        100 * before.coverage, 100 * after.coverage);
    EXPECT_GT(report.smoothing[0].strength, 0) << "seed " << seed;
    own += before.rmse / trials, smooth += after.rmse / trials;
    coverage += after.coverage / trials;
  }
  std::printf("  rmse falls to %.2f of before, coverage %.1f %%\n", smooth / own, 100 * coverage);
  EXPECT_LT(smooth, 0.7 * own);
  EXPECT_GT(coverage, 0.85);
  EXPECT_LT(coverage, 0.95);
}

TEST(smoothing, of_drags_lowers_the_normal_curves_error_and_harms_no_other) {
  const unsigned seed = 71;
  FlatBody body;
  std::vector<Curve> truth[kCurveKinds];
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < 5; ++j) {
      const Vec3 at(kSpacing * i, kSpacing * j, 0);
      const double k = 300 * (1 + 4 * at[0] + 3 * at[1]);
      body.add(at, -Vec3::UnitZ(), k);
      const Curve lateral = [k](double r) { return 0.8 * k * r; };
      const Curve limit = [k](double d) { return 0.3 * normal_of(k)(d); };
      for (const double depth_m : {0.004, 0.006, 0.008, 0.01})
        body.rig.flat_drag(static_cast<int>(body.k.size()) - 1, normal_of(k), lateral, limit,
                           depth_m, 0.012, 16, 300 * depth_m);
      truth[0].push_back(normal_of(k)), truth[1].push_back(lateral), truth[2].push_back(limit);
    }
  add_noise(body.rig.samples, 0.15, seed);
  FitReport report;
  const FittedCurves own = fit_curves(body.rig.samples, with_smoothing(0));
  const FittedCurves fitted =
      fit_curves(body.rig.samples, with_smoothing(std::nullopt), {}, &report);
  expect_admissible(fitted);
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    double before = 0, after = 0;
    for (std::size_t p = 0; p < 25; ++p) {
      const auto at = static_cast<Eigen::Index>(p);
      const auto name = static_cast<CurveKind>(kind);
      const double range = kind == 1 ? 0.004 : kDepth;
      before += std::pow(full_scale_rmse(fitted_curve(own, at, name), truth[kind][p], range), 2);
      after += std::pow(full_scale_rmse(fitted_curve(fitted, at, name), truth[kind][p], range), 2);
    }
    std::printf("  seed %u: %-8s strength %g, rmse to %.2f of before; %s\n", seed,
                kCurveNames[kind].data(), report.smoothing[kind].strength,
                std::sqrt(after / before), report.smoothing[kind].reason.c_str());
    EXPECT_LE(after, (kind == 0 ? 0.8 : 1.0) * before) << kCurveNames[kind] << " seed " << seed;
  }
  for (Eigen::Index p = 0; p < 25; ++p)  // the lateral curve rises strictly: slips have a root
    for (Eigen::Index j = 1; j < fitted.curves.control[1].cols(); ++j)
      EXPECT_GT(fitted.curves.control[1](p, j), fitted.curves.control[1](p, j - 1));
}

TEST(smoothing, an_abrupt_stiff_lump_is_not_smeared_beyond_its_noise) {
  const Stiffness lumpy = [](const Vec3& at) {
    return (at - Vec3(0.045, 0.045, 0)).norm() < 0.016 ? 900.0 : 300.0;
  };
  for (const unsigned seed : {41U, 42U, 43U}) {
    const FlatBody body = flat_body(10, lumpy, 0.15, seed);
    FitReport report;
    const FittedCurves own = fit_curves(body.rig.samples, with_smoothing(0));
    const FittedCurves fitted =
        fit_curves(body.rig.samples, with_smoothing(std::nullopt), {}, &report);
    expect_admissible(fitted);
    // Move of the curves at and around the lump, at full depth, in their own standard errors.
    const SplineTables tables = tabulate(own.curves.basis[0]);
    double mean = 0, most = 0, count = 0;
    for (std::size_t p = 0; p < body.k.size(); ++p) {
      const auto at = static_cast<Eigen::Index>(p);
      if ((own.position.row(at) - Eigen::RowVector3d(0.045, 0.045, 0)).norm() > 0.03) continue;
      const double before = fitted_curve(own, at, CurveKind::normal)(kDepth);
      const double after = fitted_curve(fitted, at, CurveKind::normal)(kDepth);
      const double sign = body.k[p] > 500 ? -1 : 1;  // smearing lowers the lump, lifts the rest
      const double move =
          sign * (after - before) /
          fit::curve_deviation(fit::view(tables), own.covariance[0].row(at), kDepth);
      mean += move, most = std::max(most, move), ++count;
    }
    std::printf(
        "  seed %u: strength %g, gain %.2f, towards the other side by %.2f deviations "
        "(mean), %.2f (most)\n",
        seed, report.smoothing[0].strength, report.smoothing[0].gain, mean / count, most);
    EXPECT_LT(mean / count, 0.5) << "seed " << seed;
    EXPECT_LT(most, 3) << "seed " << seed;
    const Errors before = errors_of(own, body.k), after = errors_of(fitted, body.k);
    std::printf("    rmse %.2f %% -> %.2f %%, coverage %.1f %%\n", 100 * before.rmse,
                100 * after.rmse, 100 * after.coverage);
    EXPECT_LT(after.rmse, 1.02 * before.rmse);
  }
}

TEST(smoothing, where_points_have_nothing_in_common_is_none) {
  for (const unsigned seed : {51U, 52U, 53U}) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(100, 900);
    FlatBody body = flat_body(
        8, [&](const Vec3&) { return any(random); }, 0.05, seed);
    FitReport report;
    const FittedCurves own = fit_curves(body.rig.samples, with_smoothing(0));
    const FittedCurves fitted =
        fit_curves(body.rig.samples, with_smoothing(std::nullopt), {}, &report);
    EXPECT_EQ(report.smoothing[0].strength, 0) << "seed " << seed;
    std::printf("  seed %u: strength %g, %s\n", seed, report.smoothing[0].strength,
                report.smoothing[0].reason.c_str());
  }
}

TEST(smoothing, without_noise_is_none_and_changes_no_bit) {
  for (const bool is_even : {true, false}) {
    FlatBody body = flat_body(
        6, is_even ? Stiffness([](const Vec3&) { return 300.0; }) : Stiffness(smooth_stiffness), 0,
        0);
    FitReport report;
    FitCache cache;
    const FittedCurves own = fit_curves(body.rig.samples, with_smoothing(0));
    const FittedCurves fitted =
        fit_curves(body.rig.samples, with_smoothing(std::nullopt), {}, &report, &cache);
    for (const SmoothingReport& kind : report.smoothing) EXPECT_EQ(kind.strength, 0);
    expect_same_curves(own, fitted);
    EXPECT_EQ(cache.own_control[0].size(), 0);
  }
}

TEST(smoothing, does_not_narrow_bands_for_an_error_that_neighbours_have_in_common) {
  FlatBody body = flat_body(
      6, [](const Vec3&) { return 300.0; }, 0, 0);
  Samples& samples = body.rig.samples;
  std::mt19937 random(21);
  std::normal_distribution<double> normal(0, 1);
  double wave[20];
  for (double& w : wave) w = 0.3 * normal(random);
  for (Eigen::Index i = 0; i < samples.rows(); ++i)  // of every recording alike, and little more
    samples.force(i, 2) += wave[i % 20] + 0.02 * normal(random);
  FitOptions options = with_smoothing(0);
  options.pieces = {2, 1, 1};
  FitReport own, smooth;
  fit_curves(samples, options, {}, &own);
  options.smoothing = 1e5;
  fit_curves(samples, options, {}, &smooth);
  std::printf("  band %.2f %% -> %.2f %%; %s\n", 100 * own.median_band[0],
              100 * smooth.median_band[0], smooth.smoothing[0].reason.c_str());
  EXPECT_GT(smooth.median_band[0], 0.9 * own.median_band[0]);
}

TEST(smoothing, keeps_two_sheets_close_to_each_other_apart) {
  FlatBody body;
  for (const double side : {0.0, 1.0})
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j)
        body.add(Vec3(kSpacing * i, kSpacing * j, -0.002 * side), (2 * side - 1) * Vec3::UnitZ(),
                 300 * (1 + side));
  add_noise(body.rig.samples, 0.1, 9);
  const auto smooth_front = [&](double factor) {
    Samples samples = body.rig.samples;
    for (Eigen::Index i = 0; i < samples.rows(); ++i)
      if (samples.point[static_cast<std::size_t>(i)] >= 36) samples.force.row(i) *= factor;
    FitOptions options = with_smoothing(1000);
    options.pieces = {2, 1, 1};
    return fit_curves(samples, options).curves.control[0].topRows(36).eval();
  };
  // The strength counts in typical increments of the body: what is behind must not reach in front
  // but through that unit.
  const Controls a = smooth_front(1), b = smooth_front(1.02);
  EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 1e-3 * a.maxCoeff());
}

TEST(smoothing, leaves_failed_points_as_they_are_and_neighbours_unpoisoned) {
  FlatBody body = flat_body(6, smooth_stiffness, 0.2, 12);
  Samples samples = body.rig.samples;
  for (Eigen::Index i = 0; i < samples.rows(); ++i) {
    const auto p = samples.point[static_cast<std::size_t>(i)];
    if (p == 14) samples.status[static_cast<std::size_t>(i)] = RowStatus::not_converged;
    if (p == 22) samples.force.row(i).setConstant(std::nan(""));
  }
  const FittedCurves own = fit_curves(samples, with_smoothing(0));
  const FittedCurves fitted = fit_curves(samples, with_smoothing(100));
  EXPECT_EQ(fitted.status, own.status);
  EXPECT_EQ(fitted.message, own.message);
  for (const Eigen::Index p : {14, 22}) {
    EXPECT_EQ(fitted.status[static_cast<std::size_t>(p)], FitStatus::failed);
    EXPECT_TRUE(fitted.curves.control[0].row(p).isZero(0));
  }
  expect_admissible(fitted);
  for (Eigen::Index p = 0; p < 36; ++p) {
    if (p == 14 || p == 22) continue;
    EXPECT_GT(fitted.curves.control[0](p, fitted.curves.control[0].cols() - 1), 1);
  }
  // Kinds that no row speaks of stay: presses say nothing of the lateral curve.
  EXPECT_EQ(fitted.curves.control[1], own.curves.control[1]);
  EXPECT_NE(fitted.curves.control[0], own.curves.control[0]);
}

TEST(smoothing, of_one_or_two_points_is_possible_on_request_and_none_by_itself) {
  for (const int count : {1, 2}) {
    FlatBody body;
    for (int p = 0; p < count; ++p)
      body.add(Vec3(kSpacing * p, 0, 0), -Vec3::UnitZ(), 300 + 10.0 * p);
    add_noise(body.rig.samples, 0.2, 4);
    const FittedCurves own = fit_curves(body.rig.samples, with_smoothing(0));
    expect_same_curves(own, fit_curves(body.rig.samples, with_smoothing(std::nullopt)));
    const FittedCurves fitted = fit_curves(body.rig.samples, with_smoothing(1e6));
    expect_admissible(fitted);
    if (count == 1) expect_same_curves(own, fitted);
    if (count == 2) {
      const Controls& c = fitted.curves.control[0];
      EXPECT_LT((c.row(0) - c.row(1)).cwiseAbs().maxCoeff(), 0.01 * c.maxCoeff());
    }
  }
}

TEST(smoothing, refuses_triangles_of_other_points) {
  const FlatBody body = flat_body(3, smooth_stiffness, 0.1, 3);
  FitOptions options = with_smoothing(10);
  options.triangles.resize(1, 3);
  options.triangles << 0, 1, 9;
  EXPECT_THROW(fit_curves(body.rig.samples, options), Error);
  options.triangles << 0, 1, 4;
  const FittedCurves own = fit_curves(body.rig.samples, with_smoothing(0));
  const FittedCurves fitted = fit_curves(body.rig.samples, options);
  for (Eigen::Index p = 0; p < 9; ++p)  // corners of the triangle alone have neighbours
    EXPECT_EQ(fitted.curves.control[0].row(p) == own.curves.control[0].row(p),
              p != 0 && p != 1 && p != 4);
}

TEST(smoothing, does_not_depend_on_the_number_of_threads) {
  const FlatBody body = flat_body(6, smooth_stiffness, 0.25, 5);
  FitOptions options = with_smoothing(std::nullopt);
  options.jobs = 1;
  const FittedCurves one = fit_curves(body.rig.samples, options);
  options.jobs = 3;
  expect_same_curves(one, fit_curves(body.rig.samples, options));
}

TEST(smoothing, of_a_warm_fit_with_one_changed_recording_is_that_of_a_whole_fit) {
  FlatBody body = flat_body(7, smooth_stiffness, 0.25, 6);
  Samples& samples = body.rig.samples;
  FitOptions options = with_smoothing(std::nullopt);
  options.pieces = {2, 1, 1};
  FitCache first_cache, whole_cache;
  const FittedCurves first = fit_curves(samples, options, {}, nullptr, &first_cache);
  EXPECT_GT(first.smoothing[0], 0);
  EXPECT_EQ(first_cache.own_control[0].rows(), 49);
  for (Eigen::Index i = 0; i < samples.rows(); ++i)
    if (samples.point[static_cast<std::size_t>(i)] == 17) samples.force.row(i) *= 1.1;
  const FittedCurves whole = fit_curves(samples, options, {}, nullptr, &whole_cache);
  options.warm_start = &first, options.warm_cache = &first_cache;
  FitReport report;
  const FittedCurves warm = fit_curves(samples, options, {}, &report);
  EXPECT_EQ(report.kept, 48U);
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind)
    EXPECT_LT((warm.curves.control[kind] - whole.curves.control[kind]).cwiseAbs().maxCoeff(),
              1e-9 * whole.curves.control[kind].maxCoeff());
  EXPECT_EQ(warm.smoothing, whole.smoothing);
  // Without the points' own curves all are fitted again, and smoothed with the strengths kept.
  options.warm_cache = nullptr;
  const FittedCurves without = fit_curves(samples, options, {}, &report);
  EXPECT_EQ(report.kept, 0U);
  expect_same_curves(without, warm);
  options.warm_start = nullptr;
  // Smoothing switched off goes back to the points' own curves.
  options.smoothing = 0;
  const FittedCurves back = fit_curves(samples, options);
  EXPECT_EQ(back.curves.control[0], whole_cache.own_control[0]);
}

}  // namespace
}  // namespace palpate::test
