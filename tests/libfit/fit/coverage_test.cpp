#include <gtest/gtest.h>

#include "libfit/fit/spline/monotone_least_squares.hpp"
#include "tests/libfit/fit/synthetic.hpp"

// Bands of 90 % hold the truth in about 90 % of seeded trials: docs/method-identification.md,
// section 14.

namespace palpate::test {
namespace {

#ifndef COVERAGE_TRIALS
#define COVERAGE_TRIALS 24
#endif
constexpr int kTrials = COVERAGE_TRIALS;               // of each shape
constexpr double kScatter = kTrials < 100 ? 0.03 : 0;  // of the mean over so few
constexpr double kDepth = 0.01;
constexpr double kShares[] = {0.05, 0.15, 0.25, 0.35, 0.45, 0.55, 0.65, 0.75, 0.85, 0.95};

// Standard deviation of a force sensor: a part of full scale and a part of the reading.
double noise_at(double force_N, double full_N, double base, double share) {
  return std::hypot(base * full_N, share * force_N);
}

void add_growing_noise(Samples& samples, double full_N, double base, double share, bool is_lateral,
                       std::mt19937& random) {
  std::normal_distribution<double> normal(0, 1);
  for (Eigen::Index i = 0; i < samples.rows(); ++i) {
    const double sigma = noise_at(samples.force.row(i).norm(), full_N, base, share);
    for (int k = 0; k < 3; ++k)
      if (is_lateral || k == 2) samples.force(i, k) += sigma * normal(random);
  }
}

struct Coverage {
  std::array<double, kCurveKinds> inside{}, count{};
  double of(CurveKind kind) const {
    const auto k = static_cast<std::size_t>(kind);
    return inside[k] / count[k];
  }
  // Counts abscissae of one curve.
  void add(const FittedCurves& fitted, CurveKind kind, const Curve& truth, double from_m,
           double to_m) {
    const auto k = static_cast<std::size_t>(kind);
    const SplineTables tables = tabulate(fitted.curves.basis[k]);
    const Curve curve = fitted_curve(fitted, 0, kind);
    const Eigen::VectorXd covariance = fitted.covariance[k].row(0);
    for (const double share : kShares) {
      const double x = from_m + share * (to_m - from_m);
      const double band = fit::kBand90 * fit::curve_deviation(fit::view(tables), covariance, x);
      inside[k] += std::abs(curve(x) - truth(x)) <= band;
      ++count[k];
    }
  }
};

struct Shape {
  const char* name;
  Curve (*truth)(std::mt19937&);
};

double uniform(std::mt19937& random, double lo, double hi) {
  return std::uniform_real_distribution<double>(lo, hi)(random);
}

const Shape kShapes[] = {
    {"power",
     [](std::mt19937& random) -> Curve {
       const double p = uniform(random, 1, 2.5), k = uniform(random, 0.5, 3);
       return [=](double d) { return k * std::pow(d / kDepth, p); };
     }},
    {"toe",  // nothing, then a line: bounds are active along the toe
     [](std::mt19937& random) -> Curve {
       const double toe = uniform(random, 0.2, 0.5), k = uniform(random, 0.5, 3);
       return [=](double d) {
         const double t = std::max(0.0, d / kDepth - toe);
         return k * t * t / (t + 0.1);
       };
     }},
    {"line",
     [](std::mt19937& random) -> Curve {
       const double k = uniform(random, 0.5, 3);
       return [=](double d) { return k * d / kDepth; };
     }},
    {"plateau",
     [](std::mt19937& random) -> Curve {  // active at the far end
       const double k = uniform(random, 0.5, 3), s = uniform(random, 0.15, 0.4);
       return [=](double d) { return k * std::tanh(d / kDepth / s); };
     }},
};

// Coverage of the normal curve over trials of one press of 60 rows, noise and basis unknown.
Coverage press_coverage(const Shape& shape, int trials, unsigned seed) {
  Coverage coverage;
  for (int trial = 0; trial < trials; ++trial) {
    std::mt19937 random(seed + static_cast<unsigned>(trial));
    const Curve truth = shape.truth(random);
    Recorder rig;
    rig.press(rig.add_point(Vec3::UnitZ()), truth, kDepth, 60);
    add_growing_noise(rig.samples, truth(kDepth), 0.01, 0.03, false, random);
    coverage.add(fit_curves(rig.samples, {.tolerance = 0}), CurveKind::normal, truth, 0, kDepth);
  }
  return coverage;
}

TEST(coverage, of_90_percent_bands_of_presses_is_87_to_93_percent) {
  double sum = 0;
  for (const Shape& shape : kShapes) {
    const double found = press_coverage(shape, kTrials, 1000).of(CurveKind::normal);
    std::printf("  %-8s %5.1f %% of %d trials from seed 1000\n", shape.name, 100 * found, kTrials);
    RecordProperty(std::string("coverage_") + shape.name, std::to_string(found));
    EXPECT_GT(found, 0.84 - kScatter) << shape.name;  // the mean is the claim
    EXPECT_LT(found, 0.96 + kScatter) << shape.name;
    sum += found / std::size(kShapes);
  }
  EXPECT_GT(sum, 0.87 - kScatter);
  EXPECT_LT(sum, 0.93 + kScatter);
}

TEST(coverage, of_bands_of_drags_is_right_for_all_three_curves) {
  Coverage coverage;
  const int trials = 100;
  for (int trial = 0; trial < trials; ++trial) {
    std::mt19937 random(5000 + static_cast<unsigned>(trial));
    const double k = uniform(random, 200, 400), mu = uniform(random, 0.3, 0.5);
    const Curve normal = [=](double d) { return k * d * (1 + 60 * d); };
    const Curve lateral = [=](double r) { return 0.8 * k * r * (1 + 30 * r); };
    const Curve limit = [=](double d) { return mu * normal(d); };
    Recorder rig;
    const int p = rig.add_point(Vec3::UnitZ());
    rig.press(p, normal, kDepth, 30);
    for (const double depth_m : {0.003, 0.005, 0.0075, 0.01})
      rig.flat_drag(p, normal, lateral, limit, depth_m, 0.012, 24, 400 * depth_m);
    add_growing_noise(rig.samples, normal(kDepth), 0.01, 0.02, true, random);
    const FittedCurves fitted = fit_curves(
        rig.samples, {.family = CurveFamily::separable, .pieces = {2, 2, 2}, .tolerance = 0});
    double reach = 0;  // where the deepest drag slips
    while (lateral(reach) < limit(kDepth)) reach += 1e-5;
    coverage.add(fitted, CurveKind::normal, normal, 0, kDepth);
    coverage.add(fitted, CurveKind::lateral, lateral, 0, reach);
    coverage.add(fitted, CurveKind::limit, limit, 0.003, kDepth);
  }
  double sum = 0;
  for (std::size_t kind = 0; kind < kCurveKinds; ++kind) {
    const double found = coverage.of(static_cast<CurveKind>(kind));
    std::printf("  %-8s %5.1f %% of %d trials from seed 5000\n", kCurveNames[kind].data(),
                100 * found, trials);
    EXPECT_GT(found, 0.83) << kCurveNames[kind];
    EXPECT_LT(found, 0.99) << kCurveNames[kind];
    sum += found / kCurveKinds;
  }
  EXPECT_GT(sum, 0.87);
  EXPECT_LT(sum, 0.93);
}

}  // namespace
}  // namespace palpate::test
