// Presses with a tool that leans. What they store over the tilt: validation_tilt_test.cpp.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "leaning_rod.hpp"
#include "libfem/solve/experiments/simulate.hpp"

namespace palpate::fem {
namespace {

constexpr double kDeg = 0.017453292519943295;

TEST(TiltedPress, rows_say_how_the_tool_leans) {
  const Simulator simulator(rod_setup(0.3));
  const TestPoints points = one_point();
  Points deflections(1, 3);
  deflections.row(0) = 0.001 * kRodInward;
  const Lean lean = lean_of(40 * kDeg, 1);
  const Samples samples =
      simulate(simulator, paths_at(points, {{0, deflections}, {0, deflections, {}, lean}}), {});
  ASSERT_EQ(samples.lean.rows(), 2);
  EXPECT_EQ(samples.lean.row(0).norm(), 0);
  EXPECT_EQ(samples.lean.row(1), lean.transpose());
  EXPECT_EQ(samples.status[1], RowStatus::good);
  EXPECT_LT(samples.force.row(1).norm(), 0.8 * samples.force.row(0).norm());
  const Samples upright = simulate(simulator, paths_at(points, {{0, deflections}}), {});
  EXPECT_EQ(upright.lean.rows(), 0);
  EXPECT_EQ(upright.force.row(0), samples.force.row(0));
  SimulateOptions known;
  known.already_done = samples;
  EXPECT_EQ(simulate(simulator, paths_at(points, {{0, deflections}, {0, deflections, {}, lean}}),
                     {}, known)
                .lean,
            samples.lean);
}

}  // namespace
}  // namespace palpate::fem
