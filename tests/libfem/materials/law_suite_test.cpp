#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

#include "tests/libfem/materials/examples.hpp"

namespace palpate::fem {
namespace {

// Every row of material_laws() walks through this suite by its examples.

using namespace examples;

Vec9 as_vector(const Mat3& M) {
  const Mat3Rows rows = M;
  return Eigen::Map<const Vec9>(rows.data());
}

TEST(LawExamples, every_law_has_one) {
  for (const LawRow& law : material_laws())
    EXPECT_TRUE(std::any_of(all().begin(), all().end(), [&](const Example& e) {
      return e.parameters.law == law.name;
    })) << law.name;
}

class LawSuite : public testing::TestWithParam<Example> {
 protected:
  const Example& example = GetParam();
  const Material material = make_material(example.parameters, "test");
  const LawRow& law = *material.law;
  const LawConstants& constants = material.constants;
  const SmallStrain hooke = law.small_strain(constants);
  const double young_Pa = hooke.young_Pa();

  /// The states at which differences of the law make sense: not across the kink of slack fibres.
  std::vector<Mat3> smooth_states() const {
    std::vector<Mat3> all = states();
    if (example.is_kinked_at_rest)
      std::erase_if(all, [](const Mat3& F) { return (F - Mat3::Identity()).norm() < 1e-6; });
    return all;
  }
};

TEST_P(LawSuite, energy_and_stress_vanish_at_rest) {
  EXPECT_EQ(law.evaluate(constants, Mat3::Identity()).W, 0);
  EXPECT_EQ(law.evaluate(constants, Mat3::Identity()).P.norm(), 0);
}

TEST_P(LawSuite, energy_is_positive_away_from_rest) {
  const std::vector<Mat3> all = states();
  for (std::size_t s = 1; s < all.size(); ++s)
    EXPECT_GT(law.evaluate(constants, all[s]).W, 0) << "seed " << kSeed << " state " << s;
}

TEST_P(LawSuite, a_rotation_after_the_deformation_changes_no_energy_and_turns_the_stress) {
  std::mt19937 random(kSeed + 1);
  for (const Mat3& F : states()) {
    const Mat3 Q = random_rotation(random);
    const double W = law.evaluate(constants, F).W;
    const Mat3 P = law.evaluate(constants, F).P;
    SCOPED_TRACE(testing::Message() << "seed " << kSeed << " F\n" << F);
    EXPECT_NEAR(law.evaluate(constants, Q * F).W, W, 1e-12 * (W + hooke.bulk_Pa()));
    EXPECT_LE((law.evaluate(constants, Q * F).P - Q * P).norm(),
              1e-11 * (P.norm() + hooke.bulk_Pa()));
  }
}

TEST_P(LawSuite, kirchhoff_stress_is_symmetric) {
  for (const Mat3& F : states()) {
    const Mat3 tau = law.evaluate(constants, F).P * F.transpose();
    EXPECT_LE((tau - tau.transpose()).norm(), 1e-12 * (tau.norm() + hooke.bulk_Pa())) << "F\n" << F;
  }
}

TEST_P(LawSuite, tangent_is_symmetric) {
  for (const Mat3& F : states()) {
    const Mat9 A = law.evaluate(constants, F).A;
    EXPECT_EQ((A - A.transpose()).norm(), 0) << "F\n" << F;
  }
}

// Which step is best depends on the state (truncation near inversion, rounding elsewhere): the
// least error over several steps counts.
TEST_P(LawSuite, stress_is_the_derivative_of_energy) {
  std::mt19937 random(kSeed + 2);
  for (const Mat3& F : smooth_states())
    for (int direction = 0; direction < 4; ++direction) {
      const Mat3 D = random_matrix(random, 1);
      const double exact = law.evaluate(constants, F).P.cwiseProduct(D).sum();
      double least = std::numeric_limits<double>::infinity();
      for (const double h : {1e-3, 1e-4, 1e-5, 1e-6})
        least = std::min(least, std::abs((law.evaluate(constants, F + h * D).W -
                                          law.evaluate(constants, F - h * D).W) /
                                             (2 * h) -
                                         exact));
      EXPECT_LE(least, 1e-7 * (std::abs(exact) + young_Pa)) << "seed " << kSeed << " F\n" << F;
    }
}

TEST_P(LawSuite, tangent_is_the_derivative_of_stress) {
  std::mt19937 random(kSeed + 3);
  for (const Mat3& F : smooth_states())
    for (int direction = 0; direction < 4; ++direction) {
      const Mat3 D = random_matrix(random, 1);
      const Vec9 exact = law.evaluate(constants, F).A * as_vector(D);
      double least = std::numeric_limits<double>::infinity();
      for (const double h : {1e-3, 1e-4, 1e-5, 1e-6, 1e-10}) {
        const Mat3 difference =
            (law.evaluate(constants, F + h * D).P - law.evaluate(constants, F - h * D).P) / (2 * h);
        least = std::min(least, (as_vector(difference) - exact).norm());
      }
      EXPECT_LE(least, 1e-7 * (exact.norm() + young_Pa)) << "seed " << kSeed << " F\n" << F;
    }
}

TEST_P(LawSuite, small_strains_follow_hooke) {
  std::mt19937 random(kSeed + 5);
  for (const double size : {1e-3, 1e-5, 1e-7}) {
    Mat3 H = random_matrix(random, size);
    if (example.is_kinked_at_rest) {  // the matrix alone: fibres are slack when shortened
      const Vec3 a = Vec3(1, 2, -2).normalized();
      H -= (a.dot(H * a) + size) * a * a.transpose();
    }
    const Mat3 F = Mat3::Identity() + H;
    H = F - Mat3::Identity();  // what the law sees
    const Mat3 strain = (H + H.transpose()) / 2;
    const Mat3 sigma =
        2 * hooke.mu_Pa * strain + hooke.lambda_Pa * strain.trace() * Mat3::Identity();
    const double W = sigma.cwiseProduct(strain).sum() / 2;
    const double share = 100 * size;  // the remainder is of the next order
    EXPECT_LE((law.evaluate(constants, F).P - sigma).norm(), share * sigma.norm()) << size;
    EXPECT_NEAR(law.evaluate(constants, F).W, W, share * W) << size;
  }
}

TEST_P(LawSuite, where_the_volume_is_gone_energy_is_infinite_and_nothing_is_nan) {
  std::vector<Mat3> gone{Mat3::Zero(),
                         -Mat3::Identity(),
                         Vec3(0, 1, 1).asDiagonal(),
                         Vec3(-1, 1, 1).asDiagonal(),
                         Vec3(-1e-9, 1, 1).asDiagonal(),
                         Vec3(-1e6, 1e6, 1e6).asDiagonal()};
  std::mt19937 random(kSeed + 6);
  while (gone.size() < 20) {
    const Mat3 F = random_matrix(random, 2);
    if (F.determinant() < 0) gone.push_back(F);
  }
  for (const Mat3& F : gone) {
    EXPECT_EQ(law.evaluate(constants, F).W, std::numeric_limits<double>::infinity()) << "F\n" << F;
    EXPECT_TRUE(law.evaluate(constants, F).P.allFinite()) << "F\n" << F;
    EXPECT_TRUE(law.evaluate(constants, F).A.allFinite()) << "F\n" << F;
  }
}

TEST_P(LawSuite, energy_rises_as_volume_goes) {
  double before = 0;
  for (const double J : {0.5, 1e-1, 1e-2, 1e-4, 1e-6, 1e-9, 1e-12}) {
    const Mat3 F = Vec3(J, 1, 1).asDiagonal();
    const double W = law.evaluate(constants, F).W;
    EXPECT_GE(W, before) << J;
    EXPECT_TRUE(law.evaluate(constants, F).P.allFinite()) << J;
    EXPECT_TRUE(law.evaluate(constants, F).A.allFinite()) << J;
    before = W;
  }
  EXPECT_GT(before, 10 * young_Pa);
  for (const Vec3& stretch : {Vec3(1e-6, 1e-6, 1), Vec3(1e-9, 1e-5, 1e3), Vec3(1e-4, 1e-4, 1e-4)}) {
    std::mt19937 random(kSeed + 7);
    const Mat3 F = random_rotation(random) * stretch.asDiagonal();
    EXPECT_FALSE(std::isnan(law.evaluate(constants, F).W)) << "F\n" << F;
    EXPECT_FALSE(law.evaluate(constants, F).P.hasNaN()) << "F\n" << F;
    EXPECT_FALSE(law.evaluate(constants, F).A.hasNaN()) << "F\n" << F;
  }
}

TEST_P(LawSuite, volumetric_part_has_its_derivatives) {
  const auto at = [&](double J) {
    std::array<double, 3> out;
    law.volumetric(constants, J - 1, out[0], out[1], out[2]);
    return out;
  };
  EXPECT_EQ(at(1)[0], 0);
  EXPECT_EQ(at(1)[1], 0);
  for (const double J : {0.3, 0.7, 0.999, 1.0, 1.001, 1.4, 2.5}) {
    const double h = 1e-5, scale = 1e-7 * hooke.bulk_Pa();
    EXPECT_NEAR((at(J + h)[0] - at(J - h)[0]) / (2 * h), at(J)[1], scale) << J;
    EXPECT_NEAR((at(J + h)[1] - at(J - h)[1]) / (2 * h), at(J)[2], scale) << J;
  }
  for (const double J : {0.0, -0.5}) {
    EXPECT_FALSE(std::isnan(at(J)[0]));
    EXPECT_TRUE(std::isfinite(at(J)[1]) && std::isfinite(at(J)[2]));
  }
}

TEST_P(LawSuite, what_is_left_without_the_volumetric_part_has_no_bulk_modulus) {
  double U, U1, U2;
  law.volumetric(constants, 0, U, U1, U2);
  EXPECT_LE(std::abs(hooke.bulk_Pa() - U2), hooke.mu_Pa);
  // On pure dilation all is volumetric, but for shear terms of the order of mu.
  for (const double J : {0.8, 1.2}) {
    law.volumetric(constants, J - 1, U, U1, U2);
    const double W = law.evaluate(constants, std::cbrt(J) * Mat3::Identity()).W;
    if (!example.is_kinked_at_rest) {
      EXPECT_LE(std::abs(W - U), 0.1 * hooke.mu_Pa) << J;
    }
  }
}

// Fibres lie askew in the examples, so "uniaxial" holds the sides by a common stretch.
TEST_P(LawSuite, a_pull_grows_with_the_stretch_between_free_sides) {
  const auto F_of = [](double along, double across) {
    return Mat3(Vec3(along, across, across).asDiagonal());
  };
  constexpr double kMaxStretch = 3;
  double before = -std::numeric_limits<double>::infinity();
  for (int i = 0; i <= 40; ++i) {
    const double along = example.min_stretch + i * (kMaxStretch - example.min_stretch) / 40;
    double low = 0.2, high = 4;
    const auto side = [&](double across) {
      const Mat3 P = law.evaluate(constants, F_of(along, across)).P;
      return P(1, 1) + P(2, 2);
    };
    // The sides are pressed when too narrow: find the change of sign next to the isochoric stretch.
    const double isochoric = 1 / std::sqrt(along);
    for (low = isochoric; side(low) > 0;) low *= 0.95;
    for (high = isochoric; side(high) < 0;) high *= 1.05;
    for (int halving = 0; halving < 60; ++halving) {
      const double middle = (low + high) / 2;
      (side(middle) < 0 ? low : high) = middle;
    }
    const double pull = law.evaluate(constants, F_of(along, low)).P(0, 0);
    EXPECT_GT(pull, before) << "stretch " << along;
    if (std::abs(along - 1) > 1e-9) {
      EXPECT_EQ(pull > 0, along > 1) << "stretch " << along;
    }
    before = pull;
  }
}

INSTANTIATE_TEST_SUITE_P(Laws, LawSuite, testing::ValuesIn(all()),
                         [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace palpate::fem
