// Which of a body's first points are dragged, and which are pressed on two meshes besides.

#include "tools/stages/samples/first_points.hpp"

#include <gtest/gtest.h>

#include <algorithm>

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

TEST(FirstPoints, are_dragged_where_forces_stand_upright_and_over_their_range) {
  // A ridge is the softest and a fold the stiffest; forces of both lean.
  const Samples presses = presses_of({{0.1, 0.3},
                                      {0.2, 0.01},
                                      {0.3, 0.02},
                                      {0.4, 0.03},
                                      {0.5, 0.02},
                                      {0.6, 0.01},
                                      {0.7, 0.04},
                                      {0.9, 0.4},
                                      {0.35, 0.2},
                                      {0.45, 0.21},
                                      {0.55, 0.22},
                                      {0.65, 0.23}});
  const FirstPoints chosen = choose_first_points(presses);
  EXPECT_EQ(chosen.dragged, (std::vector<std::size_t>{1, 2, 4, 6}));
  EXPECT_EQ(chosen.on_two_meshes, (std::vector<std::size_t>{0, 1, 2, 4, 6, 7}));
}

TEST(FirstPoints, are_those_whose_press_came_to_its_end_as_long_as_there_are_enough) {
  Samples presses =
      presses_of({{0.2, 0}, {0.3, 0}, {0.4, 0.1}, {0.5, 0.1}, {0.6, 0.1}, {0.7, 0.1}});
  presses.status[2] = RowStatus::not_converged;
  presses.status[5] = RowStatus::not_converged;
  EXPECT_EQ(choose_first_points(presses).dragged, (std::vector<std::size_t>{2, 3, 4, 5}));
  std::fill(presses.status.begin(), presses.status.end(), RowStatus::no_contact);
  presses.force.setZero();
  EXPECT_TRUE(choose_first_points(presses).dragged.empty());
}

TEST(FirstPoints, are_all_where_there_are_few) {
  const FirstPoints chosen = choose_first_points(presses_of({{0.2, 0}, {0.3, 0.5}, {0.1, 0.1}}));
  EXPECT_EQ(chosen.dragged, (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_EQ(chosen.on_two_meshes, chosen.dragged);
}

}  // namespace
}  // namespace palpate::tools
