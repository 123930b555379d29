// A block of soft gel that softens, pressed in cycles (docs/method-body.md, section 26).

#include "libfem/solve/experiments/simulate.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/libfem/solve/block.hpp"

namespace palpate::fem {
namespace {

const Vec3 kInward = -Vec3::UnitZ();
constexpr double kDepth_m = 0.004;

SimulationSetup setup(bool softens) {
  SimulationSetup out = block_setup(0);
  if (softens) out.materials[0].softening = {1.3, 50, 0.2};
  return out;
}

TEST(CycledPress, a_press_in_and_out_and_in_again_is_softer_up_to_where_it_had_been) {
  const ToolPath path = cycled_press(0, kInward, kDepth_m);
  const PointRows soft = Simulator(setup(true)).follow(block_top(), kInward, path),
                  whole = Simulator(setup(false)).follow(block_top(), kInward, path);
  double deepest_m = 0, work_J = 0, before_N = 0, before_m = 0;
  int unloaded = 0;
  std::vector<double> force_N, share;
  for (Eigen::Index i = 0; i < soft.rows(); ++i) {
    ASSERT_EQ(soft.status[i], RowStatus::good) << i;
    ASSERT_EQ(whole.status[i], RowStatus::good) << i;
    const double d = soft.deflection.row(i).dot(kInward);
    force_N.push_back(soft.force.row(i).dot(kInward));
    share.push_back(force_N.back() / whole.force.row(i).dot(kInward));
    work_J += 0.5 * (force_N.back() + before_N) * (d - before_m);
    before_N = force_N.back();
    before_m = d;
    if (d > deepest_m * (1 - 1e-9)) {
      // Where it goes deeper than ever all but the rim's own history is first loading.
      EXPECT_NEAR(share.back(), 1, 0.01) << "at " << d;
    } else if (d < 0.9 * deepest_m) {
      EXPECT_LT(share.back(), 0.9) << "at " << d;
      ++unloaded;
    }
    deepest_m = std::max(deepest_m, d);
  }
  EXPECT_GT(unloaded, 8);
  // The way in again is the way out: rows 3, 4 and 7, 6 are at 0.4 and 0.25 of the depth.
  EXPECT_NEAR(force_N[7], force_N[3], 0.01 * force_N[3]);
  EXPECT_NEAR(force_N[6], force_N[4], 0.01 * force_N[4]);
  // To half the depth, out and in there again: less comes back than went in.
  EXPECT_GT(work_J, 0);
}

TEST(CycledPress, a_path_after_a_press_begins_out_of_touch) {
  const ToolPath path{3, Points(2 * kInward.transpose().replicate(2, 1))};
  const ToolPath out = after_press(path, kInward, 1);
  EXPECT_EQ(out.point, 3);
  ASSERT_EQ(out.deflections.rows(), 7);
  EXPECT_EQ(Vec3(out.deflections.row(2)), kInward);
  EXPECT_LT(out.deflections.row(4).dot(kInward), 0);
  EXPECT_EQ(Vec3(out.deflections.row(5)), 2 * kInward);
}

}  // namespace
}  // namespace palpate::fem
