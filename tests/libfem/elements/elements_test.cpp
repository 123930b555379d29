#include "libfem/elements/elastic_body.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace palpate::fem {
namespace {

TEST(Elements, the_rule_integrates_quadratics) {
  const auto factorial = [](int n) { return std::tgamma(n + 1.0); };
  for (int a = 0; a <= 2; ++a)
    for (int b = 0; a + b <= 2; ++b) {
      const int c = 2 - a - b;
      double sum = 0;
      for (const ElementPoint& point : element_points())
        sum += point.weight * std::pow(point.barycentric[0], a) *
               std::pow(point.barycentric[1], b) * std::pow(point.barycentric[3], c);
      const double exact = 6 * factorial(a) * factorial(b) * factorial(c) / factorial(5);
      EXPECT_NEAR(sum / exact, 1, 1e-12) << a << b << c;
    }
}

TEST(Elements, the_unit_constant_sees_only_points_with_weight) {
  const Eigen::Vector4d weight(0.1, 0, 0.2, 0.4);
  const Eigen::VectorXd mode = unit_constant(weight);
  EXPECT_NEAR(mode.cwiseAbs2().dot(weight), 1, 1e-15);
  EXPECT_EQ(mode[1], 0);
  EXPECT_EQ(mode[0], mode[3]);
  EXPECT_EQ(unit_constant(Eigen::Vector4d::Zero()), Eigen::Vector4d::Zero());
}

TEST(Elements, averaging_leaves_the_bulk_modulus_of_equal_lame_constants_at_each_point) {
  for (const double poisson : {-0.5, 0.0, 0.25, 0.3, 0.45, 0.4999}) {
    const Material material = make_material({"neo-hookean", {1e4, poisson}}, "");
    const SmallStrain hooke = material.law->small_strain(material.constants);
    const double a = averaged_share(material);
    EXPECT_NEAR(hooke.lambda_Pa * (1 - a), std::min(hooke.lambda_Pa, hooke.mu_Pa), 1e-9 * 1e4);
    EXPECT_TRUE(a >= 0 && a < 1) << poisson;
  }
}

}  // namespace
}  // namespace palpate::fem
