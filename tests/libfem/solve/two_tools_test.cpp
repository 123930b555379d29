// Two tools on one body: what one does to the other.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "block.hpp"
#include "libfem/solve/experiments/simulate.hpp"
#include "libfit/core/error.hpp"

namespace palpate::fem {
namespace {

const Vec3 kInward(0, 0, -1);
const Vec3 kFirst(0.022, 0.0283, 0.03), kSecond(0.042, 0.0317, 0.03);

/// Rows of both tools pressed straight to these depths.
PointRows press_both(const Simulator& simulator, const std::vector<std::array<double, 2>>& depth_m,
                     const Vec3& first = kFirst, const Vec3& second = kSecond) {
  const auto rows = static_cast<Eigen::Index>(depth_m.size());
  ToolPath path{0, Points(rows, 3)};
  path.second = SecondTool{second, kInward, Points(rows, 3)};
  for (Eigen::Index i = 0; i < rows; ++i) {
    const auto& [one, other] = depth_m[i];
    path.deflections.row(i) = one * kInward;
    path.second->deflections.row(i) = other * kInward;
  }
  return simulator.follow(first, kInward, path);
}

TEST(TwoTools, what_one_does_to_the_other_is_mutual) {
  // Without friction forces are the gradient of an energy over both depths.
  SimulationSetup setup = block_setup(0);
  setup.options.equilibrium.residual = 1e-6;
  setup.options.uzawa_update = false;  // whose rest is no gradient
  const Simulator simulator(setup);
  constexpr double h = 0.0004, a = 0.0025, b = 0.0015;
  const auto rows = press_both(simulator, {{a, b - h}, {a, b + h}, {a - h, b}, {a + h, b}});
  for (const RowStatus status : rows.status) ASSERT_EQ(status, RowStatus::good);
  const double by_second = (rows.force.row(2) - rows.force.row(0)).dot(kInward) / (2 * h);
  const double by_first = (rows.force.row(7) - rows.force.row(5)).dot(kInward) / (2 * h);
  EXPECT_LT(by_first, 0);  // the other's dent takes force away
  EXPECT_NEAR(by_first, by_second, 0.03 * std::abs(by_first));
}

TEST(TwoTools, names_do_not_matter) {
  const Simulator simulator(block_setup(0.3));
  const auto rows = press_both(simulator, {{0.001, 0.002}, {0.003, 0.002}});
  const auto turned = press_both(simulator, {{0.002, 0.001}, {0.002, 0.003}}, kSecond, kFirst);
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {  // of both tools by turns
    ASSERT_EQ(rows.status[i], RowStatus::good);
    ASSERT_EQ(turned.status[i], RowStatus::good);
    EXPECT_LT((rows.force.row(i) - turned.force.row(i ^ 1)).norm(),
              0.02 * rows.force.row(i).norm());
  }
}

TEST(TwoTools, a_second_tool_in_the_air_is_none) {
  const Simulator simulator(block_setup(0.3));
  const PointRows with = press_both(simulator, {{0.003, -0.0005}});
  ToolPath path{0, Points(1, 3)};
  path.deflections.row(0) = 0.003 * kInward;
  const PointRows alone = simulator.follow(kFirst, kInward, path);
  EXPECT_LT((with.force.row(0) - alone.force.row(0)).norm(), 0.02 * alone.force.norm());
  EXPECT_EQ(with.force.row(1).norm(), 0);
}

TEST(TwoTools, a_small_press_meets_the_surface_where_the_other_has_brought_it) {
  // Boussinesq on a half-space: the surface goes down by f (1 - nu^2)/(pi E r); Hertz from there.
  // The block is 30 mm thick, so at r = 6 mm its bottom takes about 0.4 of it; the measure is the
  // force of a light second press against that of one alone and as much less deep.
  SimulationSetup setup = block_setup(0);
  setup.probe = sphere_spec(0.004, 0);
  setup.options.element_size = setup.options.growth = 0.6;
  const Simulator simulator(setup);
  const Vec3 middle(0.0303, 0.0297, 0.03), aside(0.0363, 0.0297, 0.03);
  constexpr double d = 0.0005, e = 0.0004;
  const auto rows = press_both(simulator, {{d, -0.0005}, {d, e}}, middle, aside);
  ASSERT_EQ(rows.status[2], RowStatus::good);
  const double force_N = rows.force.row(0).dot(kInward),
               reduced = kYoung_Pa / (1 - kPoisson * kPoisson);
  const double hertz = 4.0 / 3 * reduced * std::sqrt(0.004);
  const double sunk_m = e - std::pow(rows.force.row(3).dot(kInward) / hertz, 2.0 / 3);
  const double half_space_m = force_N / (std::numbers::pi * reduced * 0.006);
  EXPECT_GT(sunk_m, 0.5 * half_space_m);
  EXPECT_LT(sunk_m, 1.05 * half_space_m);
}

}  // namespace
}  // namespace palpate::fem
