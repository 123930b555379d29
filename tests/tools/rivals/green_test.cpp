// Green's functions answer as their own theory says.

#include <gtest/gtest.h>

#include <memory>

#include "tests/libfem/solve/block.hpp"
#include "tools/workshop/rivals/green.hpp"

namespace palpate::tools {
namespace {

// 1 mm with a ball of 8 mm: strains are small and the simulator is near the linear body.
TEST(Green, is_our_linear_body_at_small_depth) {
  fem::SimulationSetup setup = fem::block_setup(0.3);
  const Vec3 top = fem::block_top();
  constexpr double kDepth_m = 1e-3, kRadius_m = 8e-3;
  fem::Experiments experiments = fem::press_only(1);
  experiments.depth_m = kDepth_m;
  setup.options.element_size = setup.options.growth = 0.6;
  setup.options.coarse_ratio = 1.6;
  const fem::PointRows rows =
      fem::Simulator(setup).press_and_drag(top, -Vec3::UnitZ(), experiments);
  ASSERT_EQ(rows.status[0], RowStatus::good);
  const Points window = top.transpose();
  const auto surface =
      std::make_shared<GreenSurface>(make_green_surface(setup, window, 1.2e-3, 5e-3));
  GreenContact contact(
      surface, {.radius_m = kRadius_m, .friction = 0.3, .max_sweeps = 500, .tolerance = 1e-5});
  Vec3 force = Vec3::Zero();
  for (int k = 0; k <= 50; ++k)
    force = contact.force(top + (kRadius_m - kDepth_m * k / 50) * Vec3::UnitZ());
  EXPECT_NEAR(force.z() / rows.force.row(0).z(), 1, 0.05) << force.transpose();
  EXPECT_LT(force.head<2>().norm(), 0.02 * force.norm());
  EXPECT_TRUE(contact.force(top + 2 * kRadius_m * Vec3::UnitZ()).isZero(1e-6));
}

}  // namespace
}  // namespace palpate::tools
