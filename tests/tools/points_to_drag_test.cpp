// Which of a body's first points are dragged, and which are pressed on two meshes besides.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tools/stages/samples/placement.hpp"

namespace palpate::tools {
namespace {

/// Presses along z: of each point its greatest force and how far that leans, tangential over
/// normal.
Samples presses_of(const std::vector<std::pair<double, double>>& force_and_lean) {
  constexpr int kRows = 3;
  Samples out;
  const auto points = static_cast<Eigen::Index>(force_and_lean.size());
  out.point_position = Points::Zero(points, 3);
  out.point_normal = Points::Zero(points, 3);
  out.point_normal.col(2).setOnes();
  out.deflection = out.force = Points::Zero(points * kRows, 3);
  for (Eigen::Index p = 0; p < points; ++p)
    for (int row = 0; row < kRows; ++row) {
      const auto [force_N, lean] = force_and_lean[static_cast<std::size_t>(p)];
      out.point.push_back(static_cast<std::int32_t>(p));
      out.experiment.push_back(out.point.back());
      out.kind.push_back(ExperimentKind::press);
      out.step.push_back(row);
      out.status.push_back(RowStatus::good);
      out.force.row(p * kRows + row) << lean * force_N * (row + 1) / kRows, 0,
          force_N * (row + 1) / kRows;
    }
  return out;
}

TEST(PointsToDrag, are_dragged_where_forces_stand_upright_and_over_their_range) {
  const Samples presses = presses_of({{0.10, 0.30},
                                      {0.90, 0.30},
                                      {0.20, 0.20},
                                      {0.30, 0.02},
                                      {0.35, 0.20},
                                      {0.40, 0.03},
                                      {0.45, 0.01},
                                      {0.50, 0.02},
                                      {0.55, 0.22},
                                      {0.60, 0.23},
                                      {0.25, 0.21},
                                      {0.70, 0.04}});
  EXPECT_EQ(points_to_drag(presses), (std::vector<std::size_t>{1, 2, 3, 5, 6, 8}));
}

TEST(PointsToDrag, are_those_whose_press_came_to_its_end_as_long_as_there_are_enough) {
  std::vector<std::pair<double, double>> points;
  for (int p = 0; p < 12; ++p) points.push_back({0.1 + 0.01 * p, 0.1});
  Samples presses = presses_of(points);
  for (const std::size_t point : {0, 11}) presses.status[3 * point + 2] = RowStatus::not_converged;
  EXPECT_EQ(points_to_drag(presses), (std::vector<std::size_t>{1, 2, 4, 6, 8, 10}));
  for (const std::size_t point : {4, 5}) presses.status[3 * point + 2] = RowStatus::not_converged;
  EXPECT_EQ(points_to_drag(presses), (std::vector<std::size_t>{1, 2, 4, 6, 8, 10}));
  presses.force.setZero();
  EXPECT_TRUE(points_to_drag(presses).empty());
}

TEST(PointsToDrag, are_all_where_there_are_few) {
  EXPECT_EQ(points_to_drag(presses_of({{0.2, 0}, {0.3, 0.5}, {0.1, 0.1}})),
            (std::vector<std::size_t>{0, 1, 2}));
}

TEST(PointsToDrag, what_no_dragged_force_tells_is_dragged_last) {
  // Of two hundred points all but the last bear what 0 and 1 do; 198 is further off than 197, and
  // 199 leans.
  std::vector<std::pair<double, double>> forces(2 * 100, {0.42, 0});
  forces[1] = {0.5, 0}, forces[197] = {0.6, 0}, forces[198] = {0.9, 0.05}, forces[199] = {1.5, 0.3};
  EXPECT_EQ(points_beyond_drags(presses_of(forces), {0, 1}), (std::vector<std::size_t>{198, 197}));
  EXPECT_TRUE(points_beyond_drags(presses_of(forces), {}).empty()) << "a body without drags";
  forces[198].second = 0.3;
  EXPECT_EQ(points_beyond_drags(presses_of(forces), {0, 1, 198}), (std::vector<std::size_t>{197}))
      << "a dragged one that leans tells nothing, and is not asked for";
  for (std::size_t k = 0; k < forces.size(); ++k) forces[k] = {std::pow(1.2, double(k) / 10), 0};
  EXPECT_EQ(points_beyond_drags(presses_of(forces), {0}).size(), kLastDrags);
  forces.resize(2 * kPointsPerDrag);
  EXPECT_EQ(points_beyond_drags(presses_of(forces), {0}).size(), 2u);
  forces.resize(kPointsPerDrag - 1);
  EXPECT_TRUE(points_beyond_drags(presses_of(forces), {0}).empty()) << "too few to pay for one";
}

}  // namespace
}  // namespace palpate::tools
