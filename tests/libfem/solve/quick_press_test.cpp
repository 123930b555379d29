#include "libfem/solve/experiments/simulate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "libfit/core/statistics.hpp"

namespace palpate::fem {
namespace {

constexpr int kPoints = 12, kSteps = 3;
constexpr double kOwnError = 0.004;

/// Presses whose force on one mesh is stiffness times depth.
struct BothWays {
  Samples two_meshes, one_mesh;
};

BothWays presses(const std::vector<double>& stiffness_N,
                 const std::function<double(int point, double force_N)>& ratio) {
  BothWays out;
  const auto rows = static_cast<Eigen::Index>(stiffness_N.size()) * kSteps;
  for (Samples* each : {&out.two_meshes, &out.one_mesh}) {
    each->deflection = each->force = Points::Zero(rows, 3);
    each->force_error = Eigen::VectorXd::Zero(rows);
  }
  for (Eigen::Index row = 0; row < rows; ++row) {
    const auto point = static_cast<int>(row / kSteps), step = static_cast<int>(row % kSteps);
    const double force_N = stiffness_N[point] * (step + 1);
    for (Samples* each : {&out.two_meshes, &out.one_mesh}) {
      each->point.push_back(point);
      each->step.push_back(step);
      each->kind.push_back(ExperimentKind::press);
      each->status.push_back(RowStatus::good);
    }
    out.one_mesh.force(row, 2) = -force_N;
    out.two_meshes.force(row, 2) = -force_N * ratio(point, force_N);
    out.two_meshes.force_error[row] = kOwnError * force_N * ratio(point, force_N);
  }
  return out;
}

/// Most points soft, some over something stiff, each a little different; few bits, so that
/// products are exact.
std::vector<double> two_stiffnesses(int points, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> some(0.95, 1.05);
  std::vector<double> out;
  for (int p = 0; p < points; ++p)
    out.push_back(std::round(1024 * (p % 4 == 1 ? 0.25 : 0.15) * some(random)) / 1024);
  return out;
}

double scatter(int point) { return 0.002 * std::sin(7.0 * point); }

// (M13e): coarse meshes are the stiffer the stiffer what lies below a point.
TEST(QuickPress, over_something_stiff_another_factor_holds) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    SCOPED_TRACE(seed);
    const auto by_stiffness = [](const std::vector<double>& stiffness_N) {
      return [&](int point, double) {
        return 0.97 - 0.05 * std::log(stiffness_N[point] / 0.2) + scatter(point);
      };
    };
    const auto first_N = two_stiffnesses(kPoints, seed), later_N = two_stiffnesses(40, seed + 100);
    const BothWays first = presses(first_N, by_stiffness(first_N)),
                   later = presses(later_N, by_stiffness(later_N));
    const QuickScale quick = compare_quick(first.two_meshes, first.one_mesh);
    ASSERT_EQ(quick.steps.size(), std::size_t{kSteps});
    EXPECT_NEAR(quick.slope, -0.05, 0.015);
    EXPECT_LT(quick.p95, 0.01);
    for (Eigen::Index row = 0; row < later.one_mesh.force.rows(); ++row) {
      const auto step = later.one_mesh.step[row];
      const double force_N = later.one_mesh.force.row(row).norm();
      const double off =
          quick.factor(step, force_N) * force_N / later.two_meshes.force.row(row).norm() - 1;
      EXPECT_LT(std::abs(off), quick.step(step).error) << row;
      EXPECT_LT(std::abs(off), 0.01) << row << ": one factor for all is off by 2.5 %";
    }
  }
}

// Bits: those of the median alone, as of before there were lines.
TEST(QuickPress, where_the_force_tells_nothing_one_factor_holds) {
  const auto stiffness_N = two_stiffnesses(kPoints, 1);
  std::vector<double> ratios;
  for (int p = 0; p < kPoints; ++p) ratios.push_back(0.97 + scatter(p));
  // In the order of their stiffness ratios alternate.
  std::vector<std::size_t> order(kPoints);
  for (std::size_t p = 0; p < order.size(); ++p) order[p] = p;
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return stiffness_N[a] < stiffness_N[b]; });
  for (std::size_t k = 0; k < order.size(); ++k) ratios[order[k]] = k % 2 == 0 ? 0.96875 : 0.984375;
  for (const bool is_even : {true, false}) {
    const BothWays both =
        presses(stiffness_N, [&](int point, double) { return is_even ? 0.96875 : ratios[point]; });
    const QuickScale quick = compare_quick(both.two_meshes, both.one_mesh);
    ASSERT_EQ(quick.steps.size(), std::size_t{kSteps});
    EXPECT_EQ(quick.slope, 0);
    for (int step = 0; step < kSteps; ++step) {
      std::vector<double> at_step;
      for (int p = 0; p < kPoints; ++p) {
        const Vec3 full = both.two_meshes.force.row(p * kSteps + step),
                   other = both.one_mesh.force.row(p * kSteps + step);
        at_step.push_back(full.squaredNorm() / other.dot(full));
      }
      EXPECT_EQ(quick.factor(step, 1e-3), median(at_step));
      EXPECT_EQ(quick.factor(step, 1e3), median(at_step));
    }
  }
}

TEST(QuickPress, beyond_the_forces_that_were_seen_the_factor_stays) {
  const auto stiffness_N = two_stiffnesses(kPoints, 1);
  const BothWays both = presses(stiffness_N, [&](int point, double) {
    return 0.97 - 0.05 * std::log(stiffness_N[point] / 0.2);
  });
  const QuickScale quick = compare_quick(both.two_meshes, both.one_mesh);
  EXPECT_LT(quick.slope, 0);
  const double highest_N = std::exp(quick.steps[0].highest);
  EXPECT_EQ(quick.factor(0, 5 * highest_N), quick.factor(0, 2 * highest_N));
  EXPECT_LT(quick.factor(0, highest_N), quick.factor(0, 0.9 * highest_N));
  EXPECT_GT(quick.factor(0, 5 * highest_N), 0.9);
}

TEST(QuickPress, one_point_tells_its_own_factor) {
  const BothWays both = presses({0.2}, [](int, double) { return 0.9375; });
  const QuickScale quick = compare_quick(both.two_meshes, both.one_mesh);
  ASSERT_TRUE(quick);
  EXPECT_DOUBLE_EQ(quick.factor(kSteps + 3, 1), 0.9375) << "a step beyond them has the last one's";
  EXPECT_NEAR(quick.step(0).error, kOwnError, 1e-12);
}

}  // namespace
}  // namespace palpate::fem
