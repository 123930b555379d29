#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>

#include "cylinder.hpp"

namespace palpate::fem {
namespace {

double thread_seconds() {
  timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Frictionless ball of 10 mm pressed 1, 2 .. 10 mm into the middle of the top, bottom held, 10 kPa,
/// default options. reference_N: axisymmetric Q2/P-1 solution of the same equations, good to 0.3 %.
/// shallow, deep: error allowed below 4 mm, where the contact is a few elements wide, and from there.
void compare(double poisson, const std::array<double, 10>& reference_N, double shallow, double deep) {
  const SimulationSetup setup = ball_on_cylinder(poisson);
  Experiments experiments;
  experiments.depth_m = 0.01;
  experiments.press_steps = 10;

  const double start = thread_seconds();
  const PointRows result =
      Simulator(setup).press_and_drag(Vec3::Zero(), -Vec3::UnitZ(), experiments);
  std::printf("poisson %.2f: %d nodes, twin %d, %.2f s CPU\n", poisson, result.cost.nodes,
              result.cost.twin_nodes, thread_seconds() - start);
  ASSERT_EQ(result.rows.size(), reference_N.size());
  for (std::size_t k = 0; k < reference_N.size(); ++k) {
    const PointRow& row = result.rows[k];
    const double error = -row.force.z() / reference_N[k] - 1;
    std::printf("  %2zu mm: %.6f N, error %+.2f %%, estimated %.2f %%\n", k + 1, -row.force.z(),
                100 * error, 100 * row.force_error / row.force.norm());
    EXPECT_EQ(row.status, RowStatus::good) << k + 1 << " mm";
    EXPECT_LT(std::abs(error), k + 1 < 4 ? shallow : deep) << k + 1 << " mm";
  }
}

TEST(ValidationAxi, ball_on_cylinder_meets_the_axisymmetric_reference_at_poisson_0_45) {
  compare(0.45, {0.056213, 0.162001, 0.300782, 0.465666, 0.652051, 0.855974, 1.074112, 1.303358,
                 1.540461, 1.782624},
          0.012, 0.012);
}

TEST(ValidationAxi, ball_on_cylinder_meets_the_axisymmetric_reference_at_poisson_0_49) {
  compare(0.49, {0.058636, 0.168528, 0.312130, 0.482380, 0.674115, 0.883201, 1.106157, 1.339524,
                 1.579860, 1.824296},
          0.012, 0.012);
}

}  // namespace
}  // namespace palpate::fem
