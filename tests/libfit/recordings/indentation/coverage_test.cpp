// How often the 95 % interval of `modulus` holds the truth: seeded presses of a ball to a tenth to
// half of its radius, contact at 30 to 80 % of the travel, under what sensors add.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "libfit/recordings/indentation/fit_model.hpp"
#include "tests/libfit/recordings/relaxation/relaxing_presses.hpp"

namespace palpate::recordings {
namespace {

constexpr Eigen::Index kRows = 500;
constexpr int kSeeds = 300;

// Of the largest force, added to each reading.
using Disturbance = std::vector<double> (*)(std::mt19937&);

std::vector<double> white(std::mt19937& random, double share = 0.01) {
  std::normal_distribution<double> unit(0, share);
  std::vector<double> out(kRows);
  for (double& value : out) value = unit(random);
  return out;
}

std::vector<double> plus(std::vector<double> a, const std::vector<double>& b, double share) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += share * b[i];
  return a;
}

std::vector<double> one_over_f(std::mt19937& random) {
  return plus(white(random, 0.005), testing_relaxation::slow_noise(kRows, random), 0.01);
}

// A straight line over the travel, by 5 % of the largest force either way at most.
std::vector<double> tilt(std::mt19937& random) {
  std::vector<double> line(kRows);
  for (std::size_t i = 0; i < line.size(); ++i) line[i] = static_cast<double>(i) / kRows;
  return plus(white(random), line, std::uniform_real_distribution<double>(-0.05, 0.05)(random));
}

// Interference in a cantilever's light: 2 to 7 waves over the travel.
std::vector<double> waves(std::mt19937& random) {
  std::uniform_real_distribution<double> count(2, 7), phase(0, 2 * M_PI);
  const double n = count(random), begin = phase(random);
  std::vector<double> wave(kRows);
  for (std::size_t i = 0; i < wave.size(); ++i)
    wave[i] = std::sin(begin + 2 * M_PI * n * static_cast<double>(i) / kRows);
  return plus(white(random, 0.005), wave, 0.01);
}

struct CoverageCase {
  const char* name;
  Disturbance disturbance;
  bool has_slope;  // drift = "line" in the manifest
};

class Coverage : public testing::TestWithParam<CoverageCase> {};
INSTANTIATE_TEST_SUITE_P(
    Noise, Coverage,
    testing::Values(CoverageCase{"white", [](std::mt19937& r) { return white(r); }, false},
                    CoverageCase{"one_over_f", one_over_f, false},
                    CoverageCase{"tilt", tilt, false}, CoverageCase{"waves", waves, false},
                    CoverageCase{"white_line", [](std::mt19937& r) { return white(r); }, true},
                    CoverageCase{"one_over_f_line", one_over_f, true},
                    CoverageCase{"tilt_line", tilt, true}, CoverageCase{"waves_line", waves, true}),
    [](const auto& row) { return std::string(row.param.name); });

TEST_P(Coverage, of_the_95_percent_interval_of_a_modulus_is_93_or_more) {
  constexpr double kYoung_Pa = 2000, kRange_m = 6.5e-6;
  int within = 0, all = 0;
  std::vector<double> errors, stated;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    std::mt19937 random(seed);
    const double contact_m = kRange_m * std::uniform_real_distribution<double>(0.3, 0.8)(random);
    const double depth_m = kRange_m - contact_m;
    const double radius_m = depth_m / std::uniform_real_distribution<double>(0.1, 0.5)(random);
    const Indentation press{Tip::sphere, radius_m, 0, 0, 0.5};
    const ModelLaw law = indentation_model_named("sphere")->law(press);
    const Eigen::VectorXd travel_m = Eigen::VectorXd::LinSpaced(kRows, 0, kRange_m);
    const double factor = kYoung_Pa / 0.75, full_N = factor * law(depth_m).area_m2;
    const std::vector<double> added = GetParam().disturbance(random);
    Eigen::VectorXd push_N(kRows);
    for (Eigen::Index i = 0; i < kRows; ++i)
      push_N[i] = factor * law(std::max(0., travel_m[i] - contact_m)).area_m2 +
                  full_N * added[static_cast<std::size_t>(i)];
    const auto fits = fit_models(travel_m, push_N, press, {}, {.has_slope = GetParam().has_slope});
    const auto best = best_model(fits);
    ASSERT_TRUE(best) << "seed " << seed;
    const double off_Pa = std::abs(fits[*best].young_Pa - kYoung_Pa),
                 deviation_Pa = chosen_deviation_Pa(fits, *best);
    ++all, within += off_Pa < 1.96 * deviation_Pa;
    errors.push_back(off_Pa / kYoung_Pa), stated.push_back(deviation_Pa / kYoung_Pa);
  }
  const auto median = [](std::vector<double> values) {
    std::ranges::nth_element(values,
                             values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
    return values[values.size() / 2];
  };
  std::printf("  %s: within %.1f %%, error %.2f %%, stated deviation %.2f %% (medians)\n",
              GetParam().name, 100. * within / all, 100 * median(errors), 100 * median(stated));
  EXPECT_GE(within, 0.93 * all) << "of " << all << " seeds";
}

}  // namespace
}  // namespace palpate::recordings
