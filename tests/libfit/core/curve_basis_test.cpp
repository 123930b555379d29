#include "libfit/core/curves.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "libfit/runtime/base/spline.hpp"
#include "tests/support/error_of.hpp"

namespace palpate {
namespace {

// Monotone controls with b_0 = 0 from a printed seed.
std::vector<double> random_controls(const CurveBasis& basis, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> increment(0, 1);
  std::vector<double> control(basis.size(), 0.0);
  for (std::size_t j = 1; j < control.size(); ++j) control[j] = control[j - 1] + increment(random);
  return control;
}

class EveryDegree : public testing::TestWithParam<int> {
 protected:
  CurveBasis basis{GetParam(), {0, 0.1, 0.15, 0.4, 0.5}};
  SplineTables tables = tabulate(basis);
  runtime::SplineView spline = view(tables);
};
INSTANTIATE_TEST_SUITE_P(Degrees, EveryDegree, testing::Values(1, 2, 3, 4),
                         testing::PrintToStringParamName());

TEST_P(EveryDegree, basis_sums_to_one_inside_and_past_the_last_knot) {
  for (double x = 0; x < 0.8; x += 1e-3) {
    const auto w = runtime::spline_weights(spline, runtime::find_piece(spline, x), x);
    double sum = 0;
    for (int k = 0; k <= basis.degree; ++k) sum += w.value[k];
    EXPECT_NEAR(sum, 1, 1e-14 * 20) << "x = " << x;
  }
}

TEST_P(EveryDegree, slope_is_the_derivative_of_force_and_force_of_energy) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const auto b = random_controls(basis, seed);
    for (const double x : {0.003, 0.0999, 0.12, 0.27, 0.449, 0.4999, 0.6, 2.0}) {
      const double h = 1e-6;
      const double df =
          (curve_value(spline, b.data(), x + h) - curve_value(spline, b.data(), x - h)) / (2 * h);
      const double dE =
          (curve_energy(spline, b.data(), x + h) - curve_energy(spline, b.data(), x - h)) / (2 * h);
      EXPECT_NEAR(df, curve_slope(spline, b.data(), x), 1e-4) << "seed " << seed << " x " << x;
      EXPECT_NEAR(dE, curve_value(spline, b.data(), x), 1e-7) << "seed " << seed << " x " << x;
    }
  }
}

TEST_P(EveryDegree, curve_starts_at_zero_and_never_falls) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const auto b = random_controls(basis, seed);
    EXPECT_EQ(curve_value(spline, b.data(), 0.0), 0.0);
    EXPECT_EQ(curve_value(spline, b.data(), -1.0), 0.0);
    EXPECT_EQ(curve_energy(spline, b.data(), -1.0), 0.0);
    double last = 0;
    for (double x = 1e-3; x < 1; x += 1e-3) {
      const double f = curve_value(spline, b.data(), x);
      EXPECT_GE(f, last - 1e-13) << "seed " << seed << " x " << x;
      last = f;
    }
  }
}

TEST_P(EveryDegree, force_and_slope_are_continuous_at_knots) {
  const auto b = random_controls(basis, 7);
  for (const double knot : basis.knots_m) {
    if (knot == 0) continue;
    const double below = std::nextafter(knot, 0.0);
    EXPECT_NEAR(curve_value(spline, b.data(), below), curve_value(spline, b.data(), knot), 1e-12);
    if (basis.degree > 1) {
      EXPECT_NEAR(curve_slope(spline, b.data(), below), curve_slope(spline, b.data(), knot), 1e-10);
    }
  }
}

TEST_P(EveryDegree, continues_along_the_last_slope) {
  const auto b = random_controls(basis, 3);
  const double end = basis.knots_m.back();
  const double slope = curve_slope(spline, b.data(), end);
  EXPECT_NEAR(curve_value(spline, b.data(), end + 0.7),
              curve_value(spline, b.data(), end) + 0.7 * slope, 1e-12);
}

TEST(curve_basis, refuses_bad_knots_and_degrees_by_name) {
  const auto fact = [](const CurveBasis& basis) {
    return testing_support::fact_of([&] { tabulate(basis); });
  };
  EXPECT_EQ(fact({0, {0, 1}}), "degree 0 is not 1 to 4");
  EXPECT_EQ(fact({5, {0, 1}}), "degree 5 is not 1 to 4");
  EXPECT_EQ(fact({3, {0}}), "knots must start at 0 and hold at least one piece");
  EXPECT_EQ(fact({3, {0.1, 1}}), "knots must start at 0 and hold at least one piece");
  EXPECT_EQ(fact({3, {0, 1, 1}}), "knot 2 does not lie above the one before");
  EXPECT_EQ(fact({3, {0, 1, 0.5}}), "knot 2 does not lie above the one before");
  EXPECT_EQ(fact({3, {0, std::nan("")}}), "knot 1 does not lie above the one before");
}

}  // namespace
}  // namespace palpate
