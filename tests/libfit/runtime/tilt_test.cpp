// The basis on the disc of leans (M59a): C1, never negative, sums to 1, and the frame that leans
// are given in.

#include "libfit/runtime/tool/tilt.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "libfit/core/tilt.hpp"

namespace palpate::runtime {
namespace {

constexpr unsigned kSeed = 93;

TiltNodes nodes_of(int tilts) {
  TiltNodes nodes;
  nodes.tilts = tilts;
  const double tilt[] = {0, 0.4363, 0.8727, 1.2};
  for (int j = 1; j <= tilts; ++j) nodes.sine[j] = std::sin(tilt[j]);
  return nodes;
}

/// Leans inside, on and beyond the nodes, at knots, and upright.
std::vector<TiltLean> leans(const TiltNodes& nodes) {
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> share(-1, 1);
  std::vector<TiltLean> out{{0, 0}, {1e-12, 0}, {0, -1e-5}};
  for (int i = 0; i < 300; ++i) out.push_back({share(random), share(random)});
  for (int j = 0; j <= nodes.tilts + 1; ++j) {
    const double r = tilt_knot(nodes, j);
    out.push_back({0.6 * r, -0.8 * r});
  }
  for (int i = 0; i < nodes.size(); ++i) out.push_back(nodes.lean(i));
  return out;
}

TEST(TiltWeights, are_never_negative_and_sum_to_one_as_their_slopes_sum_to_nothing) {
  for (int tilts = 1; tilts <= kMaxTilts; ++tilts) {
    const TiltNodes nodes = nodes_of(tilts);
    for (const TiltLean& lean : leans(nodes)) {
      const TiltWeights at = tilt_weights(nodes, lean);
      double sum = 0, first = 0, second = 0;
      for (int i = 0; i < nodes.size(); ++i) {
        EXPECT_GE(at.w[i], 0);
        sum += at.w[i];
        first += at.d_first[i];
        second += at.d_second[i];
      }
      SCOPED_TRACE(testing::Message() << "seed " << kSeed << ", " << tilts << " tilts, lean "
                                      << lean.first << " " << lean.second);
      EXPECT_NEAR(sum, 1, 1e-14);
      EXPECT_NEAR(first, 0, 1e-13);
      EXPECT_NEAR(second, 0, 1e-13);
    }
  }
}

TEST(TiltWeights, slopes_are_those_of_the_weights_and_have_no_jump) {
  constexpr double kStep = 1e-6;
  for (int tilts = 1; tilts <= kMaxTilts; ++tilts) {
    const TiltNodes nodes = nodes_of(tilts);
    for (const TiltLean& lean : leans(nodes)) {
      const TiltWeights at = tilt_weights(nodes, lean);
      const auto moved = [&](double first, double second) {
        return tilt_weights(nodes, {lean.first + first, lean.second + second});
      };
      const TiltWeights right = moved(kStep, 0), left = moved(-kStep, 0), up = moved(0, kStep),
                        down = moved(0, -kStep);
      SCOPED_TRACE(testing::Message() << "seed " << kSeed << ", " << tilts << " tilts, lean "
                                      << lean.first << " " << lean.second);
      for (int i = 0; i < nodes.size(); ++i) {  // second slopes jump at knots: first order there
        EXPECT_NEAR(at.d_first[i], (right.w[i] - left.w[i]) / (2 * kStep), 5e-5);
        EXPECT_NEAR(at.d_second[i], (up.w[i] - down.w[i]) / (2 * kStep), 5e-5);
        EXPECT_NEAR(right.d_first[i], left.d_first[i], 1e-4);
        EXPECT_NEAR(up.d_second[i], down.d_second[i], 1e-4);
      }
    }
  }
}

// Quadratic splines reproduce lines of control values at the means of two knots, and three
// directions the first harmonic at half of its size.
TEST(TiltWeights, a_plane_over_the_disc_is_met) {
  const TiltNodes nodes = nodes_of(2);
  for (const TiltLean& lean : leans(nodes)) {
    if (std::hypot(lean.first, lean.second) > tilt_knot(nodes, 2)) continue;
    const TiltWeights at = tilt_weights(nodes, lean);
    double sum = 0;
    for (int i = 1; i < nodes.size(); ++i) {
      const int j = 1 + (i - 1) / kTiltDirections;
      sum += at.w[i] * 0.5 * (tilt_knot(nodes, j) + tilt_knot(nodes, j + 1)) *
             kTiltCos[(i - 1) % kTiltDirections];
    }
    EXPECT_NEAR(sum, 0.5 * lean.first, 1e-12) << "seed " << kSeed;
  }
}

TEST(TiltWeights, beyond_the_last_knot_nothing_changes_with_the_tilt) {
  const TiltNodes nodes = nodes_of(2);
  const TiltWeights at = tilt_weights(nodes, {0.95, 0.1}),
                    further = tilt_weights(nodes, {0.95 * 1.04, 0.104});
  for (int i = 0; i < nodes.size(); ++i) {
    EXPECT_NEAR(at.w[i], further.w[i], 1e-14);
    EXPECT_NEAR(at.d_first[i] * 0.95 + at.d_second[i] * 0.1, 0, 1e-13);
  }
}

TEST(TiltFrame, is_the_fitters) {
  std::mt19937 random(kSeed);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 200; ++i) {
    Eigen::Vector3d u(normal(random), normal(random), normal(random));
    u.normalize();
    if (i == 0) u = Eigen::Vector3d(0, 0, 1);
    if (i == 1) u = Eigen::Vector3d(0, 0, -1);
    const Mat3 frame = palpate::tilt_frame(u);
    const TiltFrame own = tilt_frame({u.x(), u.y(), u.z()});
    EXPECT_LT((frame.col(0) - Eigen::Vector3d(own.first.x, own.first.y, own.first.z)).norm(),
              1e-14);
    EXPECT_LT((frame.col(1) - Eigen::Vector3d(own.second.x, own.second.y, own.second.z)).norm(),
              1e-14);
    const Eigen::Vector3d shaft = tilt_turn(u, Lean(0.3, -0.5)) * -u;
    const TiltLean lean = lean_of(own, {shaft.x(), shaft.y(), shaft.z()});
    EXPECT_NEAR(lean.first, 0.3, 1e-12);
    EXPECT_NEAR(lean.second, -0.5, 1e-12);
  }
}

// Turning the tool by a small angle changes the lean, and the energy by the torque times it.
TEST(TiltTorque, is_the_energys_derivative_by_a_turn_about_any_axis) {
  std::mt19937 random(kSeed);
  std::normal_distribution<double> normal;
  const auto energy = [](const TiltLean& lean) {
    return 0.3 * lean.first - 0.7 * lean.second + 0.2 * lean.first * lean.second;
  };
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d
        u = Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized(),
        axis = Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
    const Eigen::Vector3d shaft = tilt_turn(u, Lean(0.2, 0.4)) * -u;
    const TiltFrame frame = tilt_frame({u.x(), u.y(), u.z()});
    const auto lean_after = [&](double angle) {
      const Eigen::Vector3d turned = Eigen::AngleAxisd(angle, axis) * shaft;
      return lean_of(frame, {turned.x(), turned.y(), turned.z()});
    };
    const TiltLean at = lean_after(0);
    const Vec3d torque = tilt_torque(frame, {shaft.x(), shaft.y(), shaft.z()},
                                     {0.3 + 0.2 * at.second, -0.7 + 0.2 * at.first});
    constexpr double kStep = 1e-5;
    EXPECT_NEAR(dot(torque, Vec3d{axis.x(), axis.y(), axis.z()}),
                (energy(lean_after(kStep)) - energy(lean_after(-kStep))) / (2 * kStep), 1e-9)
        << "seed " << kSeed << ", turn " << i;
  }
}

}  // namespace
}  // namespace palpate::runtime
