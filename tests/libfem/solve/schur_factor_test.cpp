#include "libfem/solve/factor/schur_factor.hpp"
#include "libfem/solve/factor/multifrontal.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <numeric>
#include <random>

namespace palpate::fem {
namespace {

constexpr unsigned kSeed = 23;
constexpr int kSide = 6, kNodes = kSide * kSide * kSide;

/// A grid of nodes held up by springs, coupled to their neighbours by random blocks.
/// sign < 0: indefinite.
SymmetricBlockMatrix grid(double sign = 1) {
  const auto node = [](int x, int y, int z) { return (z * kSide + y) * kSide + x; };
  std::vector<std::vector<std::int32_t>> neighbours(kNodes);
  for (int z = 0; z < kSide; ++z)
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x)
        for (const auto& [i, j, k] : {std::array{x + 1, y, z}, {x, y + 1, z}, {x, y, z + 1}})
          if (i < kSide && j < kSide && k < kSide)
            neighbours[node(x, y, z)].push_back(node(i, j, k));
  SymmetricBlockMatrix K(neighbours);
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int n = 0; n < kNodes; ++n) {
    const Mat3 own = (n == 0 ? sign * 20 : 20) * Mat3::Identity();
    K.add(K.place(n, n), own.data());
    for (const int m : neighbours[n]) {
      double block[9];
      for (double& entry : block) entry = uniform(random);
      K.add(K.place(m, n), block);
    }
  }
  return K;
}

Eigen::MatrixXd dense(const SymmetricBlockMatrix& K) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(K.size(), K.size());
  for (int c = 0; c < K.size(); ++c)
    for (auto k = K.column_start()[c]; k < K.column_start()[c + 1]; ++k)
      out(K.row_index()[k], c) = out(c, K.row_index()[k]) = K.values()[k];
  return out;
}

std::vector<std::int32_t> first_nodes(int count) {
  std::vector<std::int32_t> nodes(count);
  std::iota(nodes.begin(), nodes.end(), 0);
  return nodes;
}

/// Springs of size `stiffness` on all contact nodes.
Eigen::MatrixXd springs(const SchurFactor& factor, double stiffness) {
  const auto size = static_cast<Eigen::Index>(3 * factor.contact_nodes().size());
  return stiffness * Eigen::MatrixXd::Identity(size, size);
}

/// How far the factor's solution of (K + springs on the contact nodes) x = b is from the dense one.
double solve_error(SchurFactor& factor, const SymmetricBlockMatrix& K, double stiffness) {
  Eigen::MatrixXd A = dense(K);
  for (const std::int32_t n : factor.contact_nodes())
    A.block<3, 3>(3 * n, 3 * n).diagonal().array() += stiffness;
  Eigen::VectorXd b(K.size()), x;
  std::mt19937 random(kSeed + 1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (double& entry : b) entry = uniform(random);
  factor.solve(b, x);
  const Eigen::VectorXd exact = A.ldlt().solve(b);
  return (x - exact).norm() / exact.norm();
}

constexpr double kSingle = 1e-5;

TEST(SchurFactor, solves_with_and_without_contact_nodes_to_single_precision) {
  for (const int count : {0, 1, 17, kSide * kSide}) {
    SymmetricBlockMatrix K = grid();
    SchurFactor factor;
    ASSERT_TRUE(factor.factor(K, first_nodes(count)));
    EXPECT_EQ(factor.contact_nodes().size(), static_cast<std::size_t>(count));
    EXPECT_LT(solve_error(factor, K, 0), kSingle) << count << " contact nodes";
    ASSERT_TRUE(factor.set_contact(springs(factor, 300)));
    EXPECT_LT(solve_error(factor, K, 300), kSingle) << count << " contact nodes";
  }
}

TEST(SchurFactor, both_precisions_leave_the_same_on_the_contact_nodes) {
  const SymmetricBlockMatrix K = grid();
  const Elimination plan = analyse_elimination(K, dissect(K), first_nodes(17));
  FrontalFactor single, twice;
  ASSERT_TRUE(eliminate<float>(plan, K, single));
  ASSERT_TRUE(eliminate<double>(plan, K, twice));
  ASSERT_EQ(single.panels.size(), twice.panels.size());
  EXPECT_NE(single.schur, twice.schur);
  EXPECT_LT((single.schur - twice.schur).norm(), kSingle * twice.schur.norm());
}

// A factorization for another number of contact nodes used to keep the dense block of the one
// before where the new block was empty, and applied it past the end of the unknowns.
TEST(SchurFactor, another_number_of_contact_nodes_never_meets_the_block_of_before) {
  SymmetricBlockMatrix K = grid();
  SchurFactor factor;
  for (const int count : {36, 0, 5, 36, 3, 0, 0, 12}) {
    ASSERT_TRUE(factor.factor(K, first_nodes(count)));
    ASSERT_EQ(factor.schur().rows(), 3 * count);
    EXPECT_LT(solve_error(factor, K, 0), kSingle) << count << " contact nodes";
    ASSERT_TRUE(factor.set_contact(springs(factor, 1e4)));
    EXPECT_LT(solve_error(factor, K, 1e4), kSingle) << count << " contact nodes, stiff";
  }
}

TEST(SchurFactor, a_failed_factorization_leaves_no_factor_and_a_later_one_is_sound) {
  SymmetricBlockMatrix K = grid(), indefinite = grid(-1);
  SchurFactor factor;
  ASSERT_TRUE(factor.factor(K, first_nodes(9)));
  ASSERT_TRUE(factor.set_contact(springs(factor, 300)));
  std::vector<std::int32_t> away(7);
  std::iota(away.begin(), away.end(), 100);
  EXPECT_FALSE(factor.factor(indefinite, away));
  EXPECT_FALSE(factor.is_factored());
  ASSERT_TRUE(factor.factor(K, away));
  EXPECT_LT(solve_error(factor, K, 0), kSingle);
}

TEST(SchurFactor, a_contact_stiffness_that_is_not_positive_leaves_the_block_as_it_was) {
  SymmetricBlockMatrix K = grid();
  SchurFactor factor;
  ASSERT_TRUE(factor.factor(K, first_nodes(9)));
  ASSERT_TRUE(factor.set_contact(springs(factor, 300)));
  EXPECT_FALSE(factor.set_contact(springs(factor, -300)));
  EXPECT_LT(solve_error(factor, K, 300), kSingle);
}

TEST(SchurFactor, halves_of_a_solve_around_the_dense_block_make_a_whole_one) {
  SymmetricBlockMatrix K = grid();
  SchurFactor factor;
  ASSERT_TRUE(factor.factor(K, first_nodes(17)));
  ASSERT_TRUE(factor.set_contact(springs(factor, 300)));
  Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(K.size(), -1, 2), whole, load, contact, halves;
  factor.solve(b, whole);
  factor.reduce(b, load);
  factor.solve_contact(load, contact);
  EXPECT_LT(((factor.schur() + springs(factor, 300)) * contact - load).norm(),
            kSingle * load.norm());
  factor.expand(contact, halves);
  EXPECT_LT((halves - whole).norm(), kSingle * whole.norm());
}

}  // namespace
}  // namespace palpate::fem
