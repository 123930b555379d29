#include "libfit/core/linear_algebra.hpp"

#include <gtest/gtest.h>

#include <random>

namespace palpate {
namespace {

TEST(LeastSquares, meets_the_conditions_of_a_minimum_without_negative_weights) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal(0, 1);
    Eigen::MatrixXd a = Eigen::MatrixXd::NullaryExpr(30, 12, [&] { return normal(random); });
    a.col(3) = a.col(7);
    const Eigen::VectorXd b = Eigen::VectorXd::NullaryExpr(30, [&] { return normal(random); });
    const auto [triangular, rotated] = triangular_system(a, b);
    const Eigen::VectorXd x = nonnegative_least_squares(triangular, rotated);
    const Eigen::VectorXd slope = a.transpose() * (b - a * x);
    EXPECT_GE(x.minCoeff(), 0) << "seed " << seed;
    EXPECT_LE(slope.maxCoeff(), 1e-8) << "seed " << seed;
    EXPECT_NEAR(slope.dot(x), 0, 1e-8) << "seed " << seed;
  }
}

}  // namespace
}  // namespace palpate
