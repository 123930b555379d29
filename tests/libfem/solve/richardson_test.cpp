#include "libfem/solve/experiments/simulator_state.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace palpate::fem {
namespace {

constexpr double kRatio = 1.6;

/// Exact forces of a press, and those of a mesh that is too stiff by excess times (h/h_fine)^2.
std::vector<Vec3> press(double excess, double h = 1) {
  std::vector<Vec3> forces;
  for (int row = 1; row <= 12; ++row)
    forces.push_back(std::pow(row, 1.5) * (1 + excess * h * h) * Vec3(0.1, 0, -1));
  return forces;
}

TEST(Richardson, an_error_of_second_order_is_taken_off_and_stays_within_the_bound) {
  const std::vector<Vec3> exact = press(0), fine = press(0.03), coarse = press(0.03, kRatio);
  const Richardson limit = richardson(fine, coarse, kRatio);
  for (std::size_t i = 0; i < exact.size(); ++i) {
    const Vec3 corrected = (1 - limit.excess) * fine[i];
    EXPECT_LT((corrected - exact[i]).norm(), 3e-3 * exact[i].norm());
    EXPECT_GT(limit.error[i], 0.8 * 0.015) << "half of what was taken off";
    EXPECT_LT(limit.error[i], 1.2 * 0.015);
  }
}

TEST(Richardson, a_row_that_differs_more_than_the_others_says_so_and_leaves_them_alone) {
  const std::vector<Vec3> fine = press(0.03);
  std::vector<Vec3> coarse = press(0.03, kRatio);
  const Richardson even = richardson(fine, coarse, kRatio);
  coarse[0] *= 1.06;
  const Richardson odd = richardson(fine, coarse, kRatio);
  EXPECT_GT(odd.error[0], 2 * even.error[0]);
  EXPECT_NEAR(odd.error[5] / even.error[5], 1, 0.2);  // the mean moved by a twelfth of 6 %
}

// Once the rows of a drag stated what the two meshes differ by along the force alone.
TEST(Richardson, a_row_that_differs_sideways_says_so) {
  const std::vector<Vec3> fine = press(0.01);
  std::vector<Vec3> coarse = press(0.01, kRatio);
  coarse[2].y() += 0.04 * coarse[2].norm();
  const Richardson limit = richardson(fine, coarse, kRatio);
  EXPECT_GT(limit.error[2], 0.02);
  EXPECT_EQ(limit.error[3], kMinError);
}

TEST(Richardson, meshes_too_far_apart_are_not_extrapolated_but_owned_up_to) {
  const Richardson limit = richardson(press(0), press(0.2), kRatio);
  EXPECT_EQ(limit.excess, 0);
  for (const double error : limit.error) EXPECT_NEAR(error, 0.2, 1e-12);
}

TEST(Richardson, grids_that_agree_by_chance_still_own_up_to_the_least_error) {
  const Richardson plain = richardson(press(0.0001), press(0.0002), kRatio);
  const Richardson border = richardson(press(0.0001), press(0.0002), kRatio, kMinErrorAtBorder);
  EXPECT_EQ(border.excess, plain.excess);
  for (const double error : plain.error) EXPECT_EQ(error, kMinError);
  for (const double error : border.error) EXPECT_EQ(error, kMinErrorAtBorder);
}

TEST(Richardson, failed_rows_count_for_nothing_and_none_to_compare_is_unknown) {
  const std::vector<Vec3> fine = press(0.01);
  std::vector<Vec3> coarse = press(0.01, kRatio);
  const double excess = richardson(fine, coarse, kRatio).excess;
  coarse[3].setZero(), coarse[11].setZero();
  const Richardson gaps = richardson(fine, coarse, kRatio);
  EXPECT_NEAR(gaps.excess, excess, 1e-12);
  EXPECT_NEAR(gaps.error[3], gaps.error[4], 1e-12) << "by the other rows";
  const Richardson none = richardson(fine, std::vector<Vec3>(fine.size(), Vec3::Zero()), kRatio);
  EXPECT_EQ(none.excess, 0);
  for (const double error : none.error) EXPECT_TRUE(std::isnan(error));
}

}  // namespace
}  // namespace palpate::fem
