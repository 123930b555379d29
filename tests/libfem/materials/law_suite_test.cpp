#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <random>

#include "libfem/materials/materials.hpp"

namespace palpate::fem {
namespace {

// Every row of material_laws() walks through this suite; a new law only adds its example here.

constexpr unsigned kSeed = 20240607;
using Vec9 = Eigen::Matrix<double, 9, 1>;
using Mat3Rows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

std::vector<double> example_values(const LawRow& law) {
  std::vector<double> values;
  for (const ParameterRow& row : law.parameters)
    values.push_back(row.name == "poisson" ? 0.45 : row.unit == "Pa" ? 10e3 : 1.0);
  return values;
}

Vec9 as_vector(const Mat3& M) {
  const Mat3Rows rows = M;
  return Eigen::Map<const Vec9>(rows.data());
}

Mat3 random_matrix(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> uniform(-size, size);
  Mat3 M;
  for (int i = 0; i < 9; ++i) M(i / 3, i % 3) = uniform(random);
  return M;
}

Mat3 random_rotation(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Eigen::Quaterniond q(normal(random), normal(random), normal(random), normal(random));
  return q.normalized().toRotationMatrix();
}

/// Seeded random states about rest and the awkward ones: J near 0.2, big shear, big rotation.
std::vector<Mat3> states() {
  std::mt19937 random(kSeed);
  std::vector<Mat3> out{Mat3::Identity()};
  while (out.size() < 12) {
    const Mat3 F = Mat3::Identity() + random_matrix(random, 0.5);
    if (F.determinant() > 0.15) out.push_back(F);
  }
  Mat3 F = Vec3(0.2, 1, 1).asDiagonal();
  out.push_back(F);
  out.push_back(random_rotation(random) * F);
  F = std::cbrt(0.2) * Mat3::Identity();
  out.push_back(F);
  F.setIdentity();
  F(0, 1) = 4;
  out.push_back(F);
  F(2, 0) = -3;
  out.push_back(F * Vec3(0.6, 0.7, 0.6).asDiagonal());
  F = Vec3(3, 2, 1.5).asDiagonal();
  out.push_back(random_rotation(random) * F);
  return out;
}

class LawSuite : public testing::TestWithParam<const LawRow*> {
 protected:
  const LawRow& law = *GetParam();
  const Material material = make_material({std::string(law.name), example_values(law)}, "test");
  const LawConstants& constants = material.constants;
  const double young_Pa = law.small_strain(constants).young_Pa();
};

TEST_P(LawSuite, energy_and_stress_vanish_at_rest) {
  EXPECT_EQ(law.energy(constants, Mat3::Identity()), 0);
  EXPECT_EQ(law.stress(constants, Mat3::Identity()).norm(), 0);
}

TEST_P(LawSuite, energy_is_positive_away_from_rest) {
  const std::vector<Mat3> all = states();
  for (std::size_t s = 1; s < all.size(); ++s)
    EXPECT_GT(law.energy(constants, all[s]), 0) << "seed " << kSeed << " state " << s;
}

TEST_P(LawSuite, a_rotation_after_the_deformation_changes_no_energy_and_turns_the_stress) {
  std::mt19937 random(kSeed + 1);
  for (const Mat3& F : states()) {
    const Mat3 Q = random_rotation(random);
    const double W = law.energy(constants, F);
    const Mat3 P = law.stress(constants, F);
    SCOPED_TRACE(testing::Message() << "seed " << kSeed << " F\n" << F);
    EXPECT_NEAR(law.energy(constants, Q * F), W, 1e-12 * (W + young_Pa));
    EXPECT_LE((law.stress(constants, Q * F) - Q * P).norm(), 1e-11 * (P.norm() + young_Pa));
  }
}

TEST_P(LawSuite, kirchhoff_stress_is_symmetric) {
  for (const Mat3& F : states()) {
    const Mat3 tau = law.stress(constants, F) * F.transpose();
    EXPECT_LE((tau - tau.transpose()).norm(), 1e-12 * (tau.norm() + young_Pa)) << "F\n" << F;
  }
}

TEST_P(LawSuite, tangent_is_symmetric) {
  for (const Mat3& F : states()) {
    const Mat9 A = law.tangent(constants, F);
    EXPECT_EQ((A - A.transpose()).norm(), 0) << "F\n" << F;
  }
}

// Which step is best depends on the state (truncation near inversion, rounding elsewhere): the least
// error over several steps counts.
TEST_P(LawSuite, stress_is_the_derivative_of_energy) {
  std::mt19937 random(kSeed + 2);
  for (const Mat3& F : states())
    for (int direction = 0; direction < 4; ++direction) {
      const Mat3 D = random_matrix(random, 1);
      const double exact = law.stress(constants, F).cwiseProduct(D).sum();
      double least = std::numeric_limits<double>::infinity();
      for (const double h : {1e-3, 1e-4, 1e-5, 1e-6})
        least = std::min(least, std::abs((law.energy(constants, F + h * D) -
                                          law.energy(constants, F - h * D)) /
                                             (2 * h) -
                                         exact));
      EXPECT_LE(least, 1e-7 * (std::abs(exact) + young_Pa)) << "seed " << kSeed << " F\n" << F;
    }
}

TEST_P(LawSuite, tangent_is_the_derivative_of_stress) {
  std::mt19937 random(kSeed + 3);
  for (const Mat3& F : states())
    for (int direction = 0; direction < 4; ++direction) {
      const Mat3 D = random_matrix(random, 1);
      const Vec9 exact = law.tangent(constants, F) * as_vector(D);
      double least = std::numeric_limits<double>::infinity();
      for (const double h : {1e-3, 1e-4, 1e-5, 1e-6}) {
        const Mat3 difference =
            (law.stress(constants, F + h * D) - law.stress(constants, F - h * D)) / (2 * h);
        least = std::min(least, (as_vector(difference) - exact).norm());
      }
      EXPECT_LE(least, 1e-7 * (exact.norm() + young_Pa)) << "seed " << kSeed << " F\n" << F;
    }
}

TEST_P(LawSuite, differences_of_energy_approach_stress_at_second_order) {
  const Mat3 F = states()[3];
  std::mt19937 random(kSeed + 4);
  const Mat3 D = random_matrix(random, 0.3);
  const double exact = law.stress(constants, F).cwiseProduct(D).sum();
  const auto error = [&](double h) {
    return std::abs(
        (law.energy(constants, F + h * D) - law.energy(constants, F - h * D)) / (2 * h) - exact);
  };
  EXPECT_NEAR(error(2e-2) / error(1e-2), 4, 0.2) << "seed " << kSeed;
}

TEST_P(LawSuite, small_strains_follow_hooke) {
  const SmallStrain hooke = law.small_strain(constants);
  std::mt19937 random(kSeed + 5);
  for (const double size : {1e-3, 1e-5, 1e-7}) {
    const Mat3 H = random_matrix(random, size);
    const Mat3 strain = (H + H.transpose()) / 2;
    const Mat3 sigma = 2 * hooke.mu_Pa * strain +
                       hooke.lambda_Pa * strain.trace() * Mat3::Identity();
    const double W = sigma.cwiseProduct(strain).sum() / 2;
    const Mat3 F = Mat3::Identity() + H;
    // The remainder is of the next order; adding H to 1 costs another 1e-16 of the strain.
    const double share = 40 * size + 1e-15 / size;
    EXPECT_LE((law.stress(constants, F) - sigma).norm(), share * sigma.norm()) << size;
    EXPECT_NEAR(law.energy(constants, F), W, share * W) << size;
  }
}

TEST_P(LawSuite, tangent_at_rest_is_hookes) {
  const SmallStrain hooke = law.small_strain(constants);
  const Mat9 A = law.tangent(constants, Mat3::Identity());
  for (int a = 0; a < 9; ++a)
    for (int b = 0; b < 9; ++b) {
      const int i = a / 3, j = a % 3, k = b / 3, l = b % 3;
      const double expected = hooke.lambda_Pa * (i == j) * (k == l) +
                              hooke.mu_Pa * ((i == k) * (j == l) + (i == l) * (j == k));
      EXPECT_NEAR(A(a, b), expected, 1e-12 * young_Pa) << a << ", " << b;
    }
}

TEST_P(LawSuite, energy_is_infinite_and_never_nan_where_the_volume_is_gone) {
  std::vector<Mat3> gone{Mat3::Zero(), -Mat3::Identity(), Vec3(0, 1, 1).asDiagonal(),
                         Vec3(-1, 1, 1).asDiagonal(), Vec3(-1e-9, 1, 1).asDiagonal(),
                         Vec3(-1e6, 1e6, 1e6).asDiagonal()};
  std::mt19937 random(kSeed + 6);
  while (gone.size() < 20) {
    const Mat3 F = random_matrix(random, 2);
    if (F.determinant() < 0) gone.push_back(F);
  }
  for (const Mat3& F : gone) {
    EXPECT_EQ(law.energy(constants, F), std::numeric_limits<double>::infinity()) << "F\n" << F;
    EXPECT_TRUE(law.stress(constants, F).allFinite()) << "F\n" << F;
    EXPECT_TRUE(law.tangent(constants, F).allFinite()) << "F\n" << F;
  }
}

TEST_P(LawSuite, energy_rises_without_bound_as_volume_goes) {
  double before = 0;
  for (const double J : {0.5, 1e-2, 1e-6, 1e-12}) {
    const double W = law.energy(constants, Vec3(J, 1, 1).asDiagonal());
    EXPECT_GT(W, before) << J;
    EXPECT_TRUE(std::isfinite(W)) << J;
    before = W;
  }
}

std::vector<const LawRow*> all_laws() {
  std::vector<const LawRow*> rows;
  for (const LawRow& row : material_laws()) rows.push_back(&row);
  return rows;
}

INSTANTIATE_TEST_SUITE_P(Laws, LawSuite, testing::ValuesIn(all_laws()), [](const auto& row) {
  std::string name(row.param->name);
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return name;
});

}  // namespace
}  // namespace palpate::fem
