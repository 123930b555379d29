#include "libfit/core/samples.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace palpate {
namespace {

// Two experiments of two rows at each point; forces tell where they come from.
Samples samples_at(const std::vector<double>& places, double force_N) {
  Samples s;
  const auto points = static_cast<Eigen::Index>(places.size());
  s.point_position = Points::Zero(points, 3);
  s.point_normal = Points::Zero(points, 3);
  s.point_normal_gradient.setZero(points, 9);
  s.deflection = s.force = s.torque = Points::Zero(4 * points, 3);
  s.force_error = Eigen::VectorXd::Zero(4 * points);
  for (std::int32_t p = 0; p < points; ++p) {
    s.point_position(p, 0) = places[static_cast<std::size_t>(p)];
    s.point_normal(p, 2) = -1;
    s.point_name.push_back("p");
    for (int row = 0; row < 4; ++row) {
      s.force(4 * p + row, 0) = force_N + 10 * places[static_cast<std::size_t>(p)] + row;
      s.point.push_back(p);
      s.experiment.push_back(2 * p + row / 2);
      s.kind.push_back(row < 2 ? ExperimentKind::press : ExperimentKind::drag);
      s.step.push_back(row % 2);
      s.status.push_back(RowStatus::good);
    }
  }
  return s;
}

TestPoints points_at(const std::vector<double>& places) {
  const Samples s = samples_at(places, 0);
  return {s.point_position, s.point_normal, s.point_name, Triangles(0, 3)};
}

TEST(SamplePoints, are_found_by_place_and_renumbered_whatever_the_order) {
  const Samples taken = take_points(samples_at({1, 2, 3}, 0), points_at({3, 9, 1}), 2);
  EXPECT_EQ(taken.point, (std::vector<std::int32_t>{0, 0, 0, 0, 2, 2, 2, 2}));
  EXPECT_EQ(taken.experiment, (std::vector<std::int32_t>{0, 0, 1, 1, 4, 4, 5, 5}));
  EXPECT_EQ(taken.force(0, 0), 30);
  EXPECT_EQ(taken.force(4, 0), 10);
  EXPECT_EQ(points_without_rows(taken), std::vector<std::int32_t>{1});
}

TEST(SamplePoints, the_last_bit_of_a_place_or_a_normal_tells_points_apart) {
  TestPoints moved = points_at({1});
  moved.position(0, 0) = std::nextafter(1.0, 2.0);
  EXPECT_EQ(take_points(samples_at({1}, 0), moved, 2).rows(), 0);
  TestPoints turned = points_at({1});
  turned.normal(0, 2) = std::nextafter(-1.0, 0.0);
  EXPECT_EQ(take_points(samples_at({1}, 0), turned, 2).rows(), 0);
}

TEST(SamplePoints, of_both_files_the_first_with_rows_counts) {
  const Samples without_rows = take_points({}, points_at({2}), 2);
  const Samples both =
      joined(joined(without_rows, samples_at({1, 2}, 100), 2), samples_at({2, 3}, 500), 2);
  const Samples taken = take_points(both, points_at({1, 2, 3}), 2);
  EXPECT_EQ(taken.rows(), 12);
  EXPECT_EQ(taken.force(4, 0), 120);
  EXPECT_EQ(taken.force(8, 0), 530);
}

TEST(SamplePoints, what_checks_found_goes_with_the_rows) {
  Samples checked = samples_at({1, 2}, 0);
  checked.step_check.assign(checked.point.size(), StepCheck::none);
  checked.step_check[5] = StepCheck::falls;  // second row of the point at 2
  const Samples unchecked = samples_at({3}, 0);
  const Samples taken = take_points(checked, points_at({2, 1}), 2);
  ASSERT_EQ(taken.step_check.size(), taken.point.size());
  EXPECT_EQ(taken.step_check[1], StepCheck::falls);
  EXPECT_EQ(std::count(taken.step_check.begin(), taken.step_check.end(), StepCheck::none), 7);
  for (const Samples& both : {joined(checked, unchecked, 2), joined(unchecked, checked, 2)}) {
    ASSERT_EQ(both.step_check.size(), both.point.size());
    EXPECT_EQ(take_points(both, points_at({2}), 2).step_check[1], StepCheck::falls);
  }
}

TEST(SamplePoints, how_the_surface_moved_goes_with_the_rows_and_is_dropped_where_some_lack_it) {
  Samples kept = samples_at({1, 2}, 0), more = samples_at({3}, 100);
  const auto fill = [](Samples& samples, float from) {
    samples.surface.resize(samples.rows(), 6);
    for (Eigen::Index i = 0; i < samples.surface.size(); ++i)
      samples.surface.data()[i] = from + static_cast<float>(i);
  };
  fill(kept, 0);
  fill(more, 1000);
  const Samples taken = take_points(kept, points_at({2, 1}), 2);
  ASSERT_EQ(taken.surface.rows(), taken.rows());
  EXPECT_EQ(taken.surface.row(0), kept.surface.row(4));
  const Samples both = joined(kept, more, 2);
  ASSERT_EQ(both.surface.rows(), 12);
  EXPECT_EQ(both.surface.row(8), more.surface.row(0));
  EXPECT_EQ(joined(kept, take_points({}, points_at({7}), 2), 2).surface, kept.surface);
  EXPECT_EQ(joined(kept, samples_at({3}, 0), 2).surface.rows(), 0);
  EXPECT_EQ(joined(samples_at({3}, 0), kept, 2).surface.rows(), 0);
}

TEST(SamplePoints, what_lies_beyond_some_points_is_what_they_do_not_hold) {
  const Samples beyond = samples_beyond(samples_at({1, 2, 3}, 0), points_at({2, 7}), 2);
  ASSERT_EQ(beyond.points(), 2);
  EXPECT_EQ(beyond.point_position(0, 0), 1);
  EXPECT_EQ(beyond.point_position(1, 0), 3);
}

TEST(SamplePoints, of_a_place_that_is_pressed_alone_and_dragged_too_are_told_apart) {
  Samples pressed = samples_at({1, 2}, 0), dragged = samples_at({2, 3}, 500);
  std::fill(pressed.kind.begin(), pressed.kind.end(), ExperimentKind::press);
  std::fill(dragged.kind.begin(), dragged.kind.end(), ExperimentKind::press);
  for (std::size_t row = 1; row < dragged.kind.size(); row += 2)
    dragged.kind[row] = ExperimentKind::drag;
  const Samples both = joined(pressed, dragged, 2);
  const Samples press = take_points(both, points_at({1, 2, 3}), 2, {{}, {}, {}});
  EXPECT_EQ(points_without_rows(press), (std::vector<std::int32_t>{2}));
  const Samples drag = take_points(both, points_at({1, 2, 3}), 2, {{true}, {true}, {true}});
  EXPECT_EQ(points_without_rows(drag), (std::vector<std::int32_t>{0}));
  const Samples beyond = samples_beyond(both, points_at({2, 3}), 2, {{true}, {true}});
  ASSERT_EQ(beyond.points(), 2);  // 1 and 2, pressed alone
  EXPECT_EQ(std::count(beyond.kind.begin(), beyond.kind.end(), ExperimentKind::drag), 0);
}

TEST(SamplePoints, presses_on_one_mesh_are_used_again_under_the_same_factor_alone) {
  Samples quick = samples_at({1, 2}, 0);
  std::fill(quick.kind.begin(), quick.kind.end(), ExperimentKind::press);
  quick.point_scale = Eigen::Vector2d(0.98, 0);
  const TestPoints points = points_at({1, 2});
  const Samples same = take_points(quick, points, 2, {{false, 0.98}, {}});
  EXPECT_TRUE(points_without_rows(same).empty());
  EXPECT_EQ(same.point_scale, quick.point_scale);
  const Samples other = take_points(quick, points, 2, {{false, 0.97}, {false, 0.98}});
  EXPECT_EQ(points_without_rows(other), (std::vector<std::int32_t>{0, 1}));
  EXPECT_EQ(joined(same, quick, 2).point_scale, (Eigen::Vector4d{0.98, 0, 0.98, 0}));
}

}  // namespace
}  // namespace palpate
