// Compiled at -O3 in every configuration: there the plain casts were dropped for six values.

#include "libfit/core/geometry.hpp"

#include <gtest/gtest.h>

#include <array>
#include <random>

namespace palpate {
namespace {

using Six = Eigen::Matrix<double, 6, 1>;

TEST(rounded_to_float, six_values_of_fixed_size_are_floats) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (int round = 0; round < 1000; ++round) {
    std::array<double, 6> value;
    for (double& x : value) x = normal(random);
    const Six rounded = rounded_to_float(Eigen::Map<const Six>(value.data()));
    const Eigen::VectorXd copy = rounded_to_float(Eigen::Map<const Six>(value.data()));
    for (int i = 0; i < 6; ++i) {
      volatile float expected = static_cast<float>(value[i]);
      EXPECT_EQ(rounded[i], static_cast<double>(expected)) << "seed 5, round " << round;
      EXPECT_EQ(copy[i], rounded[i]);
      EXPECT_NE(rounded[i], value[i]) << "the case tests nothing";
    }
  }
}

TEST(rounded_to_float, what_is_a_float_stays) {
  for (const double value : {0.0, 1.0, -0.5, 0.0999999940395355224609375})
    EXPECT_EQ(rounded_to_float(value), value);
}

}  // namespace
}  // namespace palpate
