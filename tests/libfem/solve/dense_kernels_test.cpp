#include "libfem/solve/factor/dense_kernels.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <vector>

namespace palpate::fem {
namespace {

constexpr unsigned kSeed = 7;
// Sizes below, at and above the blocks of the kernels: 24 of the inverse, 8 to 128 of Eigen's.
const std::vector<int> kSizes{0, 1, 2, 3, 9, 23, 24, 25, 48, 49, 51, 97, 129, 300};

std::vector<InstructionSet> instruction_sets() {
  std::vector<InstructionSet> out{InstructionSet::portable};
  if (has_instruction_set(InstructionSet::avx2)) out.push_back(InstructionSet::avx2);
  return out;
}

Eigen::MatrixXd positive_definite(int size) {
  std::srand(kSeed);
  const Eigen::MatrixXd A = Eigen::MatrixXd::Random(size, size);
  return A * A.transpose() + size * Eigen::MatrixXd::Identity(size, size);
}

double relative(const Eigen::MatrixXd& found, const Eigen::MatrixXd& exact) {
  return exact.size() == 0 ? 0 : (found - exact).norm() / exact.norm();
}

/// Lower triangles of the factor's columns and of what is left under them, by definition.
Eigen::MatrixXd partial_cholesky(Eigen::MatrixXd A, int own) {
  const int under = static_cast<int>(A.rows()) - own;
  const Eigen::MatrixXd L = A.topLeftCorner(own, own).llt().matrixL();
  const Eigen::MatrixXd below = L.triangularView<Eigen::Lower>()
                                    .solve(A.bottomLeftCorner(under, own).transpose())
                                    .transpose();
  A.bottomRightCorner(under, under) -= below * below.transpose();
  A.topLeftCorner(own, own) = L;
  A.bottomLeftCorner(under, own) = below;
  return A.triangularView<Eigen::Lower>();
}

TEST(DenseKernels, a_front_is_factored_as_far_as_its_own_columns) {
  for (const InstructionSet set : instruction_sets())
    for (const int size : kSizes)
      for (const int own : {0, size / 3, size}) {
        const Eigen::MatrixXd A = positive_definite(size), exact = partial_cholesky(A, own);
        Eigen::MatrixXf single = A.cast<float>();
        Eigen::MatrixXd twice = A;
        EXPECT_TRUE(dense_kernels(set).factor_front(single.data(), size, own));
        EXPECT_TRUE(dense_kernels(set).factor_front_double(twice.data(), size, own));
        const Eigen::MatrixXd lower = single.cast<double>().triangularView<Eigen::Lower>();
        const Eigen::MatrixXd lower_twice = twice.triangularView<Eigen::Lower>();
        EXPECT_LT(relative(lower, exact), 3e-7) << own << " of " << size << ", seed " << kSeed;
        EXPECT_LT(relative(lower_twice, exact), 1e-14) << own << " of " << size;
      }
}

TEST(DenseKernels, a_front_that_is_not_positive_definite_is_refused) {
  for (const InstructionSet set : instruction_sets())
    for (const int size : {3, 51, 300}) {
      Eigen::MatrixXf A = positive_definite(size).cast<float>();
      A(size - 1, size - 1) = -1;
      Eigen::MatrixXf part = A;
      EXPECT_TRUE(dense_kernels(set).factor_front(part.data(), size, size - 1));
      EXPECT_FALSE(dense_kernels(set).factor_front(A.data(), size, size)) << size;
      A.setConstant(std::numeric_limits<float>::quiet_NaN());
      EXPECT_FALSE(dense_kernels(set).factor_front(A.data(), size, size)) << size;
    }
}

TEST(DenseKernels, the_inverse_is_made_from_the_factor) {
  for (const InstructionSet set : instruction_sets())
    for (const int size : kSizes) {
      const Eigen::MatrixXd A = positive_definite(size);
      Eigen::MatrixXf inverse = A.cast<float>();
      dense_kernels(set).factor_front(inverse.data(), size, size);
      dense_kernels(set).invert_from_factor(inverse.data(), size);
      EXPECT_LT(relative(inverse.cast<double>(), A.inverse()), 2e-6) << size << ", seed " << kSeed;
      EXPECT_EQ(inverse, inverse.transpose()) << size;
    }
}

TEST(DenseKernels, a_general_system_is_solved_with_row_exchanges) {
  for (const InstructionSet set : instruction_sets())
    for (const int size : kSizes) {
      std::srand(kSeed);
      Eigen::MatrixXf A = Eigen::MatrixXf::Random(size, size);
      A.diagonal().setZero();  // no elimination without an exchange
      A.diagonal(size > 1 ? 1 : 0).array() += static_cast<float>(size);
      const Eigen::VectorXf x = Eigen::VectorXf::Random(size);
      if (size == 1) continue;
      A.bottomLeftCorner(size > 0 ? 1 : 0, size > 0 ? 1 : 0).array() += static_cast<float>(size);
      Eigen::VectorXf found = A * x;
      std::vector<int> exchanges(size);
      dense_kernels(set).factor_general(A.data(), size, exchanges.data());
      dense_kernels(set).solve_general(A.data(), size, exchanges.data(), found.data());
      EXPECT_LT(relative(found.cast<double>(), x.cast<double>()), 2e-5)
          << size << ", seed " << kSeed;
    }
}

TEST(DenseKernels, products_are_those_of_the_definition) {
  for (const InstructionSet set : instruction_sets())
    for (const int size : kSizes) {
      const Eigen::MatrixXd A = positive_definite(size);
      const Eigen::VectorXd x = Eigen::VectorXd::Random(size);
      Eigen::MatrixXf lower = A.cast<float>();
      lower.triangularView<Eigen::StrictlyUpper>().setConstant(1e30F);  // may not be read
      Eigen::VectorXf y(size);
      const Eigen::VectorXf single = x.cast<float>();
      dense_kernels(set).multiply_symmetric(lower.data(), size, single.data(), y.data());
      EXPECT_LT(relative(y.cast<double>(), A * x), 1e-6) << size << ", seed " << kSeed;
      Eigen::MatrixXd general = Eigen::MatrixXd::Random(size, size);
      Eigen::VectorXd z(size);
      dense_kernels(set).multiply(general.data(), size, x.data(), z.data());
      EXPECT_LT(relative(z, general * x), 1e-14) << size << ", seed " << kSeed;
    }
}

}  // namespace
}  // namespace palpate::fem
