#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "tests/libfem/materials/examples.hpp"

namespace palpate::fem {
namespace {

using namespace examples;

/// The kernels of a material on eight states.
class EightStates {
 public:
  explicit EightStates(const Material& material) : material_(material), constants_(kMaxConstants) {
    for (int lane = 0; lane < kLanes; ++lane)
      for (int c = 0; c < kMaxConstants; ++c) constants_.at(c, lane) = material.constants[c];
  }

  void set(int lane, const Mat3& F) {
    for (int i = 0; i < 9; ++i) H_.at(i, lane) = F(i / 3, i % 3) - (i % 4 == 0);
  }

  void energy(InstructionSet set) { evaluate(set, 1, nullptr, nullptr); }
  void stress(InstructionSet set) { evaluate(set, 1, P_.data(), nullptr); }
  void tangent(InstructionSet set, double geometric_scale) {
    evaluate(set, geometric_scale, P_.data(), A_.data());
  }

  double J(int lane) { return J_.at(0, lane); }
  double W(int lane) { return W_.at(0, lane); }
  Mat3 P(int lane) {
    Mat3 out;
    for (int i = 0; i < 9; ++i) out(i / 3, i % 3) = P_.at(i, lane);
    return out;
  }
  Mat9 A(int lane) {
    Mat9 out;
    for (int a = 0; a < 9; ++a)
      for (int b = a; b < 9; ++b) out(a, b) = out(b, a) = A_.at(9 * a + b, lane);
    return out;
  }

 private:
  void evaluate(InstructionSet set, double geometric_scale, Pack* P, Pack* A) {
    material_.law->kernels->with(set).evaluate(constants_.data(), H_.data(), geometric_scale,
                                               *J_.data(), *W_.data(), P, A);
  }

  Material material_;
  PackArray constants_, H_{9}, J_{1}, W_{1}, P_{9}, A_{81};
};

class LawKernelSuite : public testing::TestWithParam<Example> {
 protected:
  const Material material = make_material(GetParam().parameters, "test");
};

TEST_P(LawKernelSuite, every_lane_of_every_instruction_set_gives_the_bits_of_the_point) {
  std::vector<Mat3> all = states();
  all.insert(all.begin() + 3,
             Mat3(Vec3(-1, 1, 1).asDiagonal()));  // turned inside out among sound ones
  all.insert(all.begin() + 13, Mat3(-Mat3::Identity()));
  for (std::size_t first = 0; first + kLanes <= all.size(); first += 5) {
    EightStates eight(material);
    for (int lane = 0; lane < kLanes; ++lane) eight.set(lane, all[first + lane]);
    for (const InstructionSet set : instruction_sets())
      for (int lane = 0; lane < kLanes; ++lane) {
        const Mat3& F = all[first + lane];
        SCOPED_TRACE(testing::Message() << "seed " << kSeed << " instruction set "
                                        << static_cast<int>(set) << " lane " << lane << " F\n"
                                        << F);
        const double W = material.law->evaluate(material.constants, F).W;
        const Mat3 P = material.law->evaluate(material.constants, F).P;
        eight.energy(set);
        EXPECT_EQ(eight.W(lane), W);
        EXPECT_NEAR(eight.J(lane), F.determinant(), 1e-14 * std::max(1.0, std::pow(F.norm(), 3)));
        eight.stress(set);
        EXPECT_EQ(eight.W(lane), W);
        EXPECT_EQ(eight.P(lane), P);
        eight.tangent(set, 1.0);
        EXPECT_EQ(eight.W(lane), W);
        EXPECT_EQ(eight.P(lane), P);
        EXPECT_EQ(eight.A(lane), material.law->evaluate(material.constants, F).A);
      }
  }
}

TEST_P(LawKernelSuite, volumetric_kernels_give_the_bits_of_the_point) {
  for (const InstructionSet set : instruction_sets()) {
    const LawKernels& kernels = material.law->kernels->with(set);
    PackArray constants(kMaxConstants), in(1), out(3);
    for (int lane = 0; lane < kLanes; ++lane) {
      in.at(0, lane) = -0.9 + 0.37 * lane;
      for (int c = 0; c < kMaxConstants; ++c) constants.at(c, lane) = material.constants[c];
    }
    kernels.volumetric(constants.data(), *in.data(), out.data()[0], out.data()[1], out.data()[2]);
    for (int lane = 0; lane < kLanes; ++lane) {
      double U, U1, U2;
      material.law->volumetric(material.constants, in.at(0, lane), U, U1, U2);
      EXPECT_EQ(out.at(0, lane), U);
      EXPECT_EQ(out.at(1, lane), U1);
      EXPECT_EQ(out.at(2, lane), U2);
    }
  }
}

TEST_P(LawKernelSuite,
       without_the_geometric_part_the_tangent_is_semidefinite_where_the_law_says_so) {
  if (GetParam().max_J_without_geometric == 0) GTEST_SKIP() << "the law does not say so";
  std::vector<Mat3> all = states();
  std::mt19937 random(kSeed + 20);
  while (all.size() < 200) {
    const Mat3 F = Mat3::Identity() + random_matrix(random, 1.2);
    if (F.determinant() > 0.02) all.push_back(F);
  }
  std::erase_if(all,
                [](const Mat3& F) { return F.determinant() > GetParam().max_J_without_geometric; });
  EightStates eight(material);
  const auto min_of = [&](double geometric_scale) {
    eight.tangent(best_instruction_set(), geometric_scale);
    const Mat9 A = eight.A(0);
    return Eigen::SelfAdjointEigenSolver<Mat9>(A).eigenvalues()[0] / A.norm();
  };
  int indefinite_when_exact = 0;
  for (const Mat3& F : all) {
    eight.set(0, F);
    EXPECT_GE(min_of(0.0), -1e-11) << "seed " << kSeed << " F\n" << F;
    indefinite_when_exact += min_of(1.0) < -1e-11;
  }
  EXPECT_GT(indefinite_when_exact, 0);  // otherwise nothing was tested
}

// Lanes and points of another law have zero constants; whatever comes out is masked, but must not
// be anything that traps or loops.
TEST_P(LawKernelSuite, zero_constants_at_rest_are_harmless) {
  Material nothing = material;
  nothing.constants = {};
  EightStates eight(nothing);
  for (int lane = 0; lane < kLanes; ++lane) eight.set(lane, Mat3::Identity());
  for (const InstructionSet set : instruction_sets()) {
    eight.tangent(set, 1.0);
    EXPECT_EQ(eight.W(0), 0);
    EXPECT_EQ(eight.P(0), Mat3::Zero());
    EXPECT_EQ(eight.A(0), Mat9::Zero());
  }
}

INSTANTIATE_TEST_SUITE_P(Laws, LawKernelSuite, testing::ValuesIn(all()),
                         [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace palpate::fem
