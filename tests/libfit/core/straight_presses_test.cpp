#include "libfit/core/samples.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

namespace palpate {
namespace {

// A press along `inward` with 20 rows to 3 mm, whose tool and force stand aside as `aside` says.
template <class Aside>
Samples press(const Vec3& inward, const Aside& aside, ExperimentKind kind = ExperimentKind::press) {
  Samples s;
  s.point_position = Points::Zero(1, 3);
  s.point_normal = inward.normalized().transpose();
  s.point_name = {"p"};
  const Eigen::Index n = 20;
  s.deflection.resize(n, 3), s.force.resize(n, 3), s.torque = Points::Zero(n, 3);
  s.force_error = Eigen::VectorXd::Constant(n, 1e-3);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double depth_m = 3e-3 * static_cast<double>(i + 1) / static_cast<double>(n);
    const auto [moved_m, force_N] = aside(depth_m);
    s.deflection.row(i) = depth_m * s.point_normal.row(0) + moved_m.transpose();
    s.force.row(i) = 2e4 * std::pow(depth_m, 1.5) * s.point_normal.row(0) + force_N.transpose();
    s.point.push_back(0), s.experiment.push_back(0), s.kind.push_back(kind);
    s.step.push_back(static_cast<std::int32_t>(i)), s.status.push_back(RowStatus::good);
  }
  return s;
}

TEST(straight_presses, jitter_and_lean_leave_depth_and_force_along_the_normal) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> draw;
    const Vec3 inward = Vec3(draw(random), draw(random), draw(random)).normalized();
    const Vec3 side = inward.unitOrthogonal();
    const double jitter_m = std::pow(10, -7 + 0.0875 * seed), lean = 0.0044 * seed;
    Samples samples = press(inward, [&](double depth_m) {
      const Vec3 noise = jitter_m * Vec3(draw(random), draw(random), draw(random));
      return std::pair{Vec3(lean * depth_m * side + noise - noise.dot(inward) * inward),
                       Vec3(0.1 * side + 0.01 * draw(random) * inward.cross(side))};
    });
    const Eigen::VectorXd depth_m = samples.deflection * inward, push_N = samples.force * inward;
    EXPECT_TRUE(has_crooked_press(samples)) << "seed " << seed;
    EXPECT_TRUE(straighten_presses(samples).empty()) << "seed " << seed;
    EXPECT_FALSE(has_crooked_press(samples)) << "seed " << seed;
    const Points along = depth_m * inward.transpose(), push = push_N * inward.transpose();
    EXPECT_LT((samples.deflection - along).cwiseAbs().maxCoeff(), 1e-17) << "seed " << seed;
    EXPECT_LT((samples.force - push).cwiseAbs().maxCoeff(), 1e-14) << "seed " << seed;
  }
}

// What simulators write: exact presses, whose forces stand off the normal where the body slopes.
TEST(straight_presses, a_straight_press_keeps_every_bit_and_its_side_force) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> draw;
    const Vec3 inward(draw(random), draw(random), draw(random));
    const Vec3 side = inward.unitOrthogonal();
    Samples samples = press(inward, [&](double depth_m) {
      return std::pair<Vec3, Vec3>{Vec3::Zero(), 100 * depth_m * side};
    });
    const Samples before = samples;
    EXPECT_FALSE(has_crooked_press(samples)) << "seed " << seed;
    EXPECT_TRUE(straighten_presses(samples).empty());
    EXPECT_EQ(samples.deflection, before.deflection) << "seed " << seed;
    EXPECT_EQ(samples.force, before.force) << "seed " << seed;
  }
}

TEST(straight_presses, a_press_that_slides_and_feels_it_stays) {
  const Vec3 side = Vec3::UnitX();
  const auto slide = [&](double depth_m) {
    return std::pair<Vec3, Vec3>{depth_m * side, 30 * depth_m * side};
  };
  Samples samples = press(Vec3::UnitZ(), slide);
  const Samples before = samples;
  EXPECT_EQ(straighten_presses(samples), std::vector<std::int32_t>{0});
  EXPECT_EQ(samples.deflection, before.deflection);
  EXPECT_FALSE(has_crooked_press(samples)) << "nothing is left to straighten";

  Samples smooth = press(Vec3::UnitZ(), [&](double depth_m) {
    return std::pair<Vec3, Vec3>{depth_m * side, Vec3::Zero()};
  });
  EXPECT_TRUE(straighten_presses(smooth).empty()) << "nothing is felt sideways";
  EXPECT_EQ(smooth.deflection.col(0).cwiseAbs().maxCoeff(), 0);
}

TEST(straight_presses, drags_and_paths_are_left_alone) {
  for (const ExperimentKind kind :
       {ExperimentKind::drag, ExperimentKind::path, ExperimentKind::pair, ExperimentKind::tool}) {
    Samples samples = press(
        Vec3::UnitZ(),
        [](double) {
          return std::pair<Vec3, Vec3>{Vec3(1e-4, 0, 0), Vec3::Zero()};
        },
        kind);
    const Samples before = samples;
    EXPECT_FALSE(has_crooked_press(samples));
    straighten_presses(samples);
    EXPECT_EQ(samples.deflection, before.deflection);
  }
}

TEST(straight_presses, rows_that_are_no_numbers_judge_nothing) {
  Samples samples = press(Vec3::UnitZ(), [](double) {
    return std::pair<Vec3, Vec3>{Vec3(1e-6, 0, 0), Vec3::Zero()};
  });
  samples.deflection.row(4).setConstant(std::nan(""));
  samples.force.row(5).setConstant(std::nan(""));
  EXPECT_TRUE(straighten_presses(samples).empty());
  EXPECT_EQ(samples.deflection(3, 0), 0);
  EXPECT_FALSE(samples.deflection.row(4).allFinite());
}

}  // namespace
}  // namespace palpate
