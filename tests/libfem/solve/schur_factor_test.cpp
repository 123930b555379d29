#include "libfem/solve/factor/schur_factor.hpp"
#include "libfem/solve/equilibrium/equilibrium.hpp"
#include "tests/libfem/fields.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <numeric>
#include <random>

#include "tests/libfem/matrix_entries.hpp"
#include "tests/support/error_of.hpp"

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
    const Eigen::Matrix3d own = (n == 0 ? sign * 20 : 20) * Eigen::Matrix3d::Identity();
    K.add(K.place(n, n), own.data());
    for (const int m : neighbours[n]) {
      double block[9];
      for (double& entry : block) entry = uniform(random);
      K.add(K.place(m, n), block);
    }
  }
  return K;
}

std::vector<std::int32_t> first_nodes(int count) {
  std::vector<std::int32_t> nodes(count);
  std::iota(nodes.begin(), nodes.end(), 0);
  return nodes;
}

/// How far the factor's solution of K x = b is from the dense one.
double solve_error(SchurFactor& factor, const SymmetricBlockMatrix& K) {
  Eigen::VectorXd b(K.size()), x;
  std::mt19937 random(kSeed + 1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (double& entry : b) entry = uniform(random);
  factor.solve(b, x);
  const Eigen::VectorXd exact = dense(K).ldlt().solve(b);
  return (x - exact).norm() / exact.norm();
}

constexpr double kSingle = 1e-5;

TEST(SchurFactor, solves_with_and_without_contact_nodes_to_single_precision) {
  for (const int count : {0, 1, 17, kSide * kSide}) {
    SymmetricBlockMatrix K = grid();
    SchurFactor factor;
    ASSERT_TRUE(factor.factor(K, first_nodes(count)));
    EXPECT_EQ(factor.contact_nodes().size(), static_cast<std::size_t>(count));
    EXPECT_LT(solve_error(factor, K), kSingle) << count << " contact nodes";
  }
}

TEST(SchurFactor, flexibility_is_the_part_of_the_inverse_on_the_contact_nodes) {
  SymmetricBlockMatrix K = grid();
  SchurFactor factor;
  ASSERT_TRUE(factor.factor(K, first_nodes(17)));
  const Eigen::MatrixXd inverse = dense(K).inverse();
  const auto& nodes = factor.contact_nodes();
  for (std::size_t i = 0; i < nodes.size(); ++i)
    for (std::size_t j = 0; j < nodes.size(); ++j)
      EXPECT_LT((factor.flexibility().block<3, 3>(3 * i, 3 * j).cast<double>() -
                 inverse.block<3, 3>(3 * nodes[i], 3 * nodes[j]))
                    .norm(),
                kSingle * inverse.norm());
}

TEST(SchurFactor, both_precisions_leave_the_same_on_the_contact_nodes) {
  const SymmetricBlockMatrix K = grid();
  const Elimination plan = analyse_elimination(K, dissect(K), first_nodes(17));
  FrontalFactor single, twice;
  EliminationRoom<float> single_room;
  EliminationRoom<double> double_room;
  ASSERT_TRUE(eliminate(plan, K, single_room, single));
  ASSERT_TRUE(eliminate(plan, K, double_room, twice));
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
    ASSERT_EQ(factor.flexibility().rows(), 3 * count);
    EXPECT_LT(solve_error(factor, K), kSingle) << count << " contact nodes";
  }
}

TEST(SchurFactor, a_failed_factorization_leaves_no_factor_and_a_later_one_is_sound) {
  SymmetricBlockMatrix K = grid(), indefinite = grid(-1);
  SchurFactor factor;
  ASSERT_TRUE(factor.factor(K, first_nodes(9)));
  std::vector<std::int32_t> away(7);
  std::iota(away.begin(), away.end(), 100);
  EXPECT_FALSE(factor.factor(indefinite, away));
  EXPECT_FALSE(factor.is_factored());
  ASSERT_TRUE(factor.factor(K, away));
  EXPECT_LT(solve_error(factor, K), kSingle);
}

TEST(SchurFactor, is_stable_with_springs_that_hold_and_not_with_springs_that_push) {
  SymmetricBlockMatrix K = grid();
  SchurFactor factor;
  ASSERT_TRUE(factor.factor(K, first_nodes(9)));
  const Eigen::MatrixXd springs = 300 * Eigen::MatrixXd::Identity(27, 27);
  EXPECT_TRUE(factor.is_stable_with(springs));
  EXPECT_FALSE(factor.is_stable_with(-springs));
  EXPECT_LT(solve_error(factor, K), kSingle) << "asking changes nothing";
}

TEST(SchurFactor, halves_of_a_solve_around_the_dense_block_make_a_whole_one) {
  SymmetricBlockMatrix K = grid();
  SchurFactor factor;
  ASSERT_TRUE(factor.factor(K, first_nodes(17)));
  Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(K.size(), -1, 2), whole, load, halves;
  factor.solve(b, whole);
  factor.reduce(b, load);
  const Eigen::VectorXd contact = (factor.flexibility() * load.cast<float>()).cast<double>();
  EXPECT_LT((factor.schur() * contact - load).norm(), kSingle * load.norm());
  factor.expand(contact, halves);
  EXPECT_LT((halves - whole).norm(), kSingle * whole.norm());
}

/// A block with a flexibility, and contact that is not symmetric on a few of its unknowns; the
/// tangent of both.
struct Condensed {
  Eigen::MatrixXd flexibility, C;
  Eigen::MatrixXf G;  // the flexibility in single precision
  CondensedTangent tangent;
  std::vector<Eigen::Index> touching{2, 3, 4, 9, 10, 14};
  Eigen::VectorXd residual;

  Condensed() {
    std::mt19937 random(kSeed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    const auto fill = [&](auto& matrix) {
      for (double& entry : matrix.reshaped()) entry = uniform(random);
    };
    Eigen::MatrixXd root(18, 18);
    fill(root);
    flexibility = root * root.transpose() + Eigen::MatrixXd::Identity(18, 18);
    C.resize(6, 6), fill(C);
    C += 5 * Eigen::MatrixXd::Identity(6, 6);
    residual.resize(18), fill(residual);
    G = flexibility.cast<float>();
    tangent.cover(G, touching);
    tangent.set_contact(C);
  }
};

TEST(CondensedTangent, a_step_solves_newtons_equations_of_the_whole_block) {
  const Condensed at;
  const CondensedTangent::CondensedStep step = at.tangent.step(at.G, at.residual);
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(18, 18);
  C(at.touching, at.touching) = at.C;
  EXPECT_LT((step.w + at.flexibility * step.z).norm(), kSingle * step.w.norm());
  EXPECT_LT((step.z - C * step.w + at.residual).norm(), 10 * kSingle * at.residual.norm());
}

TEST(CondensedTangent, keeps_unknowns_that_hold_what_touches_until_they_are_far_too_many) {
  Condensed at;
  at.tangent.cover(at.G, {2, 3, 4, 9, 10});
  EXPECT_EQ(at.tangent.unknowns(), at.touching);
  at.tangent.cover(at.G, {2, 3, 4});
  EXPECT_EQ(at.tangent.unknowns().size(), 3u);
  at.tangent.cover(at.G, {2, 3, 5});
  EXPECT_EQ(at.tangent.unknowns(), (std::vector<Eigen::Index>{2, 3, 5}));
}

// A probe that lifts off after the factor was made anew left the stiffness of what had touched.
TEST(CondensedTangent, without_contact_a_step_takes_away_what_was_exerted) {
  Condensed at;
  at.tangent.clear();
  at.tangent.cover(at.G, {});
  at.tangent.set_contact(Eigen::MatrixXd(0, 0));
  const CondensedTangent::CondensedStep step = at.tangent.step(at.G, at.residual);
  EXPECT_EQ(step.z, -at.residual);
  EXPECT_LT((step.w - at.flexibility * at.residual).norm(), kSingle * step.w.norm());
}

// On a linear problem, mixing is as good as GMRES: exact after as many steps as K has eigenvalues.
TEST(AndersonMixing, ends_a_linear_iteration_after_as_many_steps_as_its_operator_has_eigenvalues) {
  Eigen::VectorXd u = Eigen::VectorXd::Zero(12), K = Eigen::VectorXd::LinSpaced(12, 1, 4),
                  true_K = K;
  for (int i = 0; i < 12; ++i) true_K[i] *= i % 3 == 0 ? 1.5 : i % 3 == 1 ? 0.8 : 1.1;
  const Eigen::VectorXd load = Eigen::VectorXd::LinSpaced(12, -1, 2);
  AndersonMixing mixing(5);
  for (int step = 0; step < 5; ++step) {
    const Eigen::VectorXd residual = load - true_K.cwiseProduct(u);
    const Eigen::VectorXd d = mixing.mix(residual.cwiseQuotient(K), residual);
    u += d;
    mixing.record(d);
  }
  EXPECT_LT((true_K.cwiseProduct(u) - load).norm(), 1e-6 * load.norm());
}

TEST(SchurFactor, refuses_what_takes_more_memory_than_is_allowed_before_it_takes_it) {
  const SymmetricBlockMatrix K = grid();
  const Elimination plan = analyse_elimination(K, dissect(K), first_nodes(20));
  const double bytes = elimination_bytes(plan);
  double entries = 0;
  for (int s = 0; s < plan.supernodes(); ++s)
    entries += 9 * plan.columns(s) * (plan.height(s) - 0.5 * plan.columns(s));
  EXPECT_GT(bytes, sizeof(float) * entries);
  SchurFactor factor;
  bound_factor_memory(0.9 * bytes);
  const std::string text = testing_support::error_of([&] { factor.factor(K, first_nodes(20)); });
  EXPECT_NE(text.find("memory_GB", text.find('\n')), std::string::npos) << text;
  bound_factor_memory(1.1 * bytes);
  EXPECT_TRUE(factor.factor(K, first_nodes(20)));
  bound_factor_memory(2e9);
}

}  // namespace
}  // namespace palpate::fem
