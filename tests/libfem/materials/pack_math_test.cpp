#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "libfem/materials/ogden.hpp"
#include "tests/libfem/materials/examples.hpp"

namespace palpate::fem {
namespace {

using namespace examples;

// Differences in units of the last place of the expected value.
double ulps(double value, long double expected) {
  const double unit = std::max(std::abs(std::nextafter(static_cast<double>(expected), 1e308) -
                                        static_cast<double>(expected)),
                               std::numeric_limits<double>::denorm_min());
  return static_cast<double>(std::abs(value - expected)) / unit;
}

/// log(1 + x) - x and exp(x) - 1 - x for |x| < 0.1, where the differences cancel in long doubles
/// too.
long double log_less_series(long double x) {
  long double sum = 0, power = x;
  for (int n = 2; n < 30; ++n) sum += (power *= -x) / n;
  return sum;
}
long double exp_less_series(long double x) {
  long double sum = 0, term = x;
  for (int n = 2; n < 30; ++n) sum += term *= x / n;
  return sum;
}

TEST(PackMath, log1p_and_what_is_left_of_it_are_right_to_the_last_places) {
  std::mt19937 random(kSeed + 30);
  std::uniform_real_distribution<double> exponent(-40, 40), sign(-1, 1);
  for (int i = 0; i < 200000; ++i) {
    double x = std::exp(exponent(random));
    if (x < 1 && sign(random) < 0) x = -x;
    double log, less;
    log1p_of(x, log, less);
    const long double exact = std::log1p(static_cast<long double>(x));
    ASSERT_LE(ulps(log, exact), 3) << "seed " << kSeed << " x " << x;
    const long double left = std::abs(x) < 0.1 ? log_less_series(x) : exact - x;
    ASSERT_LE(ulps(less, left), 24) << "seed " << kSeed << " x " << x;
  }
}

TEST(PackMath, expm1_and_what_is_left_of_it_are_right_to_the_last_places) {
  std::mt19937 random(kSeed + 31);
  std::uniform_real_distribution<double> exponent(-40, std::log(690.0)), sign(-1, 1);
  for (int i = 0; i < 200000; ++i) {
    double x = std::exp(exponent(random));
    if (sign(random) < 0) x = -x;
    double expm1, less;
    expm1_of(x, expm1, less);
    const long double exact = std::expm1(static_cast<long double>(x));
    ASSERT_LE(ulps(expm1, exact), 4) << "seed " << kSeed << " x " << x;
    const long double left = std::abs(x) < 0.1 ? exp_less_series(x) : exact - x;
    ASSERT_LE(ulps(less, left), 24) << "seed " << kSeed << " x " << x;
  }
}

TEST(PackMath, exponents_out_of_range_saturate) {
  double expm1, less;
  for (const double x : {701.0, 1e6, 1e300}) {
    expm1_of(x, expm1, less);
    EXPECT_TRUE(std::isfinite(expm1));
    EXPECT_GT(expm1, 1e304);
    expm1_of(-x, expm1, less);
    EXPECT_EQ(expm1, -1);
  }
}

TEST(PackMath, lanes_give_the_bits_of_doubles) {
  std::mt19937 random(kSeed + 32);
  std::uniform_real_distribution<double> uniform(-0.99, 5);
  for (int round = 0; round < 100; ++round) {
    Pack x, log, log_less, expm1, expm1_less;
    for (int lane = 0; lane < kLanes; ++lane) x[lane] = uniform(random);
    log1p_of(x, log, log_less);
    expm1_of(x, expm1, expm1_less);
    for (int lane = 0; lane < kLanes; ++lane) {
      const double one = x[lane];
      double a, b, c, d;
      log1p_of(one, a, b);
      expm1_of(one, c, d);
      EXPECT_EQ(log[lane], a);
      EXPECT_EQ(log_less[lane], b);
      EXPECT_EQ(expm1[lane], c);
      EXPECT_EQ(expm1_less[lane], d);
    }
  }
}

TEST(Spectral, vectors_and_values_rebuild_the_matrix_whatever_repeats) {
  std::mt19937 random(kSeed + 33);
  for (const double size : {1.0, 1e-6, 1e-100})
    for (const double apart : {1.0, 1e-5, 1e-8, 1e-12, 0.0})
      for (int round = 0; round < 200; ++round) {
        const Mat3 Q = random_rotation(random);
        const Mat3 M =
            size * Q * Vec3(1 + apart, 1 - apart, round % 2 ? -2 : 1).asDiagonal() * Q.transpose();
        const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> symmetric = (M + M.transpose()) / 2;
        Eigen::Matrix<double, 3, 3, Eigen::RowMajor> V;
        Vec3 values;
        eigen_of(symmetric.data(), values.data(), V.data());
        EXPECT_LE((V * values.asDiagonal() * V.transpose() - symmetric).norm(), 4e-15 * size);
        EXPECT_LE((V.transpose() * V - Mat3::Identity()).norm(), 4e-15);
      }
}

TEST(Spectral, of_a_zero_matrix_is_the_identity) {
  const double zero[9] = {};
  double values[3], vectors[9];
  eigen_of(zero, values, vectors);
  EXPECT_EQ(values[0], 0);
  EXPECT_EQ(vectors[0], 1);
  EXPECT_EQ(vectors[1], 0);
}

}  // namespace
}  // namespace palpate::fem
