#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <memory>

#include "tests/libfem/materials/examples.hpp"

namespace palpate::fem {
namespace {

using namespace examples;

/// Kernels on elements reduced to a point: of the first point with weight 1, the shape functions of
/// nodes 0 to 2 have the unit vectors for gradients. Then u_ai = H_ia, force_ai = P_ia and the blocks of
/// the stiffness are A.
class PointKernel {
 public:
  explicit PointKernel(const Material& material) : material_(material) {
    const int constants = material.law->constants_used;
    constants_ = PackArray(kTetPoints * constants);
    for (int lane = 0; lane < kLanes; ++lane) {
      for (int a = 0; a < 3; ++a) gradient_.at(3 * a + a, lane) = 1;
      weight_.at(0, lane) = 1;
      for (int c = 0; c < constants; ++c) constants_.at(c, lane) = material.constants[c];
    }
  }

  void set(int lane, const Mat3& F) {
    for (int i = 0; i < 3; ++i)
      for (int a = 0; a < 3; ++a) displacement_.at(3 * a + i, lane) = F(i, a) - (i == a);
  }

  const ElementResult& energy() {
    material_.law->kernels->energy(batch(), displacement_.data(), *result_);
    return *result_;
  }
  const ElementResult& force() {
    material_.law->kernels->force(batch(), displacement_.data(), *result_);
    return *result_;
  }
  const ElementResult& stiffness(double bend) {
    material_.law->kernels->stiffness(batch(), displacement_.data(), bend, *result_);
    return *result_;
  }

  static Mat3 stress(const ElementResult& result, int lane) {
    Mat3 P;
    for (int i = 0; i < 3; ++i)
      for (int a = 0; a < 3; ++a) P(i, a) = result.force[3 * a + i][lane];
    return P;
  }

  /// The lower block triangle has each entry of A at least once.
  static Mat9 tangent(const ElementResult& result, int lane) {
    Mat9 A;
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b <= a; ++b)
        for (int i = 0; i < 3; ++i)
          for (int k = 0; k < 3; ++k)
            A(3 * i + a, 3 * k + b) = A(3 * k + b, 3 * i + a) =
                result.stiffness[9 * (a * (a + 1) / 2 + b) + 3 * i + k][lane];
    return A;
  }

 private:
  ElementBatch batch() const { return {gradient_.data(), weight_.data(), constants_.data()}; }

  Material material_;
  PackArray gradient_{kTetPoints * kTetNodes * 3}, weight_{kTetPoints}, constants_;
  PackArray displacement_{3 * kTetNodes};
  std::unique_ptr<ElementResult> result_ = std::make_unique<ElementResult>();
};

class LawKernels : public testing::TestWithParam<Example> {
 protected:
  const Material material = make_material(GetParam().parameters, "test");
};

// Points are evaluated with the portable instruction set, kernels with this processor's.
TEST_P(LawKernels, give_in_every_lane_the_bits_of_the_point) {
  std::vector<Mat3> all = states();
  all.insert(all.begin() + 3, Mat3(Vec3(-1, 1, 1).asDiagonal()));
  all.insert(all.begin() + 13, Mat3(-Mat3::Identity()));
  for (std::size_t first = 0; first + kLanes <= all.size(); first += 5) {
    PointKernel kernel(material);
    for (int lane = 0; lane < kLanes; ++lane) kernel.set(lane, all[first + lane]);
    for (int lane = 0; lane < kLanes; ++lane) {
      // As the kernel sees it: the sum of u_a grad N_a starts from 0.
      const Mat3& F = all[first + lane];
      SCOPED_TRACE(testing::Message() << "seed " << kSeed << " lane " << lane << " F\n" << F);
      const double W = material.law->energy(material.constants, F);
      const Mat3 P = material.law->stress(material.constants, F);
      EXPECT_EQ(kernel.energy().energy[lane], W);
      const ElementResult& force = kernel.force();
      EXPECT_EQ(force.energy[lane], W);
      EXPECT_EQ(PointKernel::stress(force, lane), P);
      const ElementResult& stiffness = kernel.stiffness(1.0);
      EXPECT_EQ(stiffness.energy[lane], W);
      EXPECT_EQ(PointKernel::stress(stiffness, lane), P);
      EXPECT_EQ(PointKernel::tangent(stiffness, lane), material.law->tangent(material.constants, F));
    }
  }
}

TEST_P(LawKernels, have_a_semidefinite_tangent_without_the_bent_part_where_the_law_says_so) {
  if (GetParam().most_J_at_bend_0 == 0) GTEST_SKIP() << "the law does not say so";
  std::vector<Mat3> all = states();
  std::mt19937 random(kSeed + 20);
  while (all.size() < 200) {
    const Mat3 F = Mat3::Identity() + random_matrix(random, 1.2);
    if (F.determinant() > 0.02) all.push_back(F);
  }
  std::erase_if(all, [](const Mat3& F) { return F.determinant() > GetParam().most_J_at_bend_0; });
  PointKernel kernel(material);
  int indefinite_when_exact = 0;
  for (const Mat3& F : all) {
    kernel.set(0, F);
    const Mat9 A = PointKernel::tangent(kernel.stiffness(0.0), 0);
    const double least = Eigen::SelfAdjointEigenSolver<Mat9>(A).eigenvalues()[0];
    EXPECT_GE(least, -1e-11 * A.norm()) << "seed " << kSeed << " F\n" << F;
    const Mat9 exact = PointKernel::tangent(kernel.stiffness(1.0), 0);
    indefinite_when_exact += Eigen::SelfAdjointEigenSolver<Mat9>(exact).eigenvalues()[0] < 0;
  }
  EXPECT_GT(indefinite_when_exact, 0);  // otherwise nothing was tested
}

TEST(IdleLanes, give_nothing_whatever_the_law) {
  for (const Example& example : all()) {
    const Material material = make_material(example.parameters, "test");
    PackArray gradient(kTetPoints * kTetNodes * 3), weight(kTetPoints), displacement(3 * kTetNodes),
        constants(kTetPoints * material.law->constants_used);
    const ElementBatch batch{gradient.data(), weight.data(), constants.data()};
    const auto result = std::make_unique<ElementResult>();
    material.law->kernels->stiffness(batch, displacement.data(), 1.0, *result);
    for (int lane = 0; lane < kLanes; ++lane) {
      EXPECT_EQ(result->energy[lane], 0) << example.name;
      for (const Pack& force : result->force) EXPECT_EQ(force[lane], 0) << example.name;
      for (const Pack& entry : result->stiffness) EXPECT_EQ(entry[lane], 0) << example.name;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Laws, LawKernels, testing::ValuesIn(all()),
                         [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace palpate::fem
