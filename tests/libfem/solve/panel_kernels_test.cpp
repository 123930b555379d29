#include "libfem/solve/factor/dense_kernels.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <numeric>
#include <random>

namespace palpate::fem {
namespace {

constexpr unsigned kSeed = 5;

/// Columns of a factor, well conditioned, and a supernode whose rows below are nodes in disorder.
struct Supernode {
  int own, under;
  Eigen::MatrixXf columns;
  std::vector<float> panel;
  std::vector<std::int32_t> rows;

  Supernode(int own_count, int under_count) : own(own_count), under(under_count) {
    std::srand(kSeed);
    columns = Eigen::MatrixXf::Random(own + under, own);
    columns.diagonal().array() += 0.7F * static_cast<float>(own) + 1;
    panel.assign(panel_size(own, under) + kPanelPadding, 0.0F);
    pack_panel(columns.data(), own, under, panel.data());
    rows.resize(under / 3);
    std::iota(rows.begin(), rows.end(), own / 3);
    std::shuffle(rows.begin(), rows.end(), std::mt19937(kSeed));
  }

  Eigen::VectorXf solve_half(bool is_forward, InstructionSet set, Eigen::VectorXf x) const {
    std::vector<float> work(panel_work_size(own, under), 1e30F);  // nothing of it may be used
    const PanelTask task{panel.data(), own, under, rows.data(), x.data(), x.data(), work.data()};
    const PanelKernels kernels = panel_kernels(set);
    (is_forward ? kernels.forward : kernels.backward)(task);
    return x;
  }
  Eigen::MatrixXd below_in_order() const {
    Eigen::MatrixXd out(under, own);
    for (std::size_t r = 0; r < rows.size(); ++r)
      out.middleRows<3>(3 * (rows[r] - own / 3)) =
          columns.middleRows<3>(own + 3 * static_cast<Eigen::Index>(r)).cast<double>();
    return out;
  }
};

TEST(PanelKernels, halves_of_a_solve_are_right_at_every_size) {
  for (const int own : {3, 6, 15, 18, 33, 48, 51, 99})
    for (const int under : {0, 3, 15, 18, 48, 75}) {
      const Supernode one(own, under);
      const Eigen::VectorXf x = Eigen::VectorXf::Random(own + under);
      const Eigen::MatrixXd square = one.columns.topRows(own).cast<double>();
      const auto T = square.triangularView<Eigen::Lower>();
      const Eigen::MatrixXd P = one.below_in_order();
      Eigen::VectorXd down = x.cast<double>(), up = down;
      T.solveInPlace(down.head(own));
      down.tail(under) -= P * down.head(own);
      up.head(own) -= P.transpose() * up.tail(under);
      T.transpose().solveInPlace(up.head(own));
      const auto differs = [&](bool is_forward, const Eigen::VectorXd& exact) {
        const Eigen::VectorXf found = one.solve_half(is_forward, best_instruction_set(), x);
        return (found.cast<double>() - exact).norm() / exact.norm();
      };
      EXPECT_LT(differs(true, down), 2e-6) << own << " over " << under << ", seed " << kSeed;
      EXPECT_LT(differs(false, up), 2e-6) << own << " over " << under << ", seed " << kSeed;
    }
}

TEST(PanelKernels, results_have_the_same_bits_on_every_instruction_set) {
  const Supernode one(51, 75);
  const Eigen::VectorXf x = Eigen::VectorXf::Random(126);
  for (const bool is_forward : {true, false}) {
    const Eigen::VectorXf plain = one.solve_half(is_forward, InstructionSet::portable, x);
    for (const InstructionSet set : {InstructionSet::avx2, InstructionSet::avx512}) {
      if (!has_instruction_set(set)) continue;
      EXPECT_EQ(plain, one.solve_half(is_forward, set, x)) << static_cast<int>(set);
    }
  }
}

}  // namespace
}  // namespace palpate::fem
