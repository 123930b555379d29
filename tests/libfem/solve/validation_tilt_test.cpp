// Presses with a tool that leans: what they store over the tilt is what the torque works.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "leaning_rod.hpp"
#include "libfem/solve/experiments/simulator.hpp"

namespace palpate::fem {
namespace {

constexpr double kDeg = 0.017453292519943295;

/// Work of the press down to the last row, by the trapezoidal rule in powers of depth: force goes
/// as depth to some power within each interval.
double work_J(const PointRows& press) {
  double work = 0, before_N = 0, before_m = 0;
  for (Eigen::Index row = 0; row < press.rows(); ++row) {
    const double depth = press.deflection.row(row).dot(kRodInward),
                 force = press.force.row(row).dot(kRodInward);
    if (before_m > 0) {
      const double power = std::log(force / before_N) / std::log(depth / before_m);
      work += (force * depth - before_N * before_m) / (power + 1);
    } else {
      work += force * depth / 2.3;
    }
    before_N = force;
    before_m = depth;
  }
  return work;
}

// The middle of the edge's rounding stays where it is as the tool turns in the plane of its lean:
// about it the torque is the derivative of the stored energy by the angle.
TEST(TiltedPress, without_friction_torque_is_the_derivative_of_the_stored_energy_by_the_tilt) {
  const Simulator simulator(rod_setup(0));
  constexpr double kStep = 5 * kDeg;
  for (const double direction : {0.4, 2.6}) {
    const auto at = [&](double tilt) { return press_rod(simulator, lean_of(tilt, direction)); };
    const PointRows less = at(25 * kDeg - kStep), here = at(25 * kDeg),
                    more = at(25 * kDeg + kStep);
    for (Eigen::Index row = 0; row < here.rows(); ++row)
      ASSERT_EQ(here.status[row], RowStatus::good);
    const double slope_Nm = (work_J(more) - work_J(less)) / (2 * kStep);
    const Vec3 towards =
        tilt_frame(kRodInward).leftCols<2>() * Lean(std::cos(direction), std::sin(direction));
    const Vec3 about = (-kRodInward).cross(towards);
    const Eigen::Index last = here.rows() - 1;
    const double torque_Nm =
        (here.torque.row(last).transpose() + kRodEdge_m * kRodInward.cross(here.force.row(last)))
            .dot(about);
    RecordProperty("torque_Nmm", std::to_string(1e3 * torque_Nm));
    RecordProperty("slope_Nmm", std::to_string(1e3 * slope_Nm));
    std::printf("  torque %.4f, slope of the energy %.4f N mm; force %.4f N\n", 1e3 * torque_Nm,
                1e3 * slope_Nm, here.force.row(last).norm());
    EXPECT_LT(torque_Nm, 0) << "the body turns it upright: tilted further it meets less";
    EXPECT_NEAR(torque_Nm, slope_Nm, 0.08 * std::abs(slope_Nm));
  }
}

}  // namespace
}  // namespace palpate::fem
