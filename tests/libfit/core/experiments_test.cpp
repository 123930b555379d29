#include "libfit/core/experiments.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

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
    s.point_position(p, 0) = places[p];
    s.point_normal(p, 2) = -1;
    s.point_name.push_back("p");
    for (int row = 0; row < 4; ++row) {
      s.force(4 * p + row, 0) = force_N + 10 * places[p] + row;
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

// Presses with drags at these places.
ExperimentList list_at(const std::vector<double>& places) {
  return experiments_at(points_at(places));
}
using Numbers = std::vector<std::size_t>;

TEST(KnownRows, are_found_by_place_and_renumbered_whatever_the_order) {
  const ExperimentList wanted = list_at({3, 9, 1});
  const Samples taken = known_rows(wanted, samples_at({1, 2, 3}, 0), 2);
  EXPECT_EQ(taken.point, (std::vector<std::int32_t>{0, 0, 0, 0, 2, 2, 2, 2}));
  EXPECT_EQ(taken.experiment, (std::vector<std::int32_t>{0, 0, 1, 1, 4, 4, 5, 5}));
  EXPECT_EQ(taken.force(0, 0), 30);
  EXPECT_EQ(taken.force(4, 0), 10);
  EXPECT_EQ(without_rows(wanted, taken, 2), Numbers{1});
}

TEST(KnownRows, the_last_bit_of_a_place_or_a_normal_tells_points_apart) {
  ExperimentList moved = list_at({1});
  moved.places.position(0, 0) = std::nextafter(1.0, 2.0);
  EXPECT_EQ(known_rows(moved, samples_at({1}, 0), 2).rows(), 0);
  ExperimentList turned = list_at({1});
  turned.places.normal(0, 2) = std::nextafter(-1.0, 0.0);
  EXPECT_EQ(known_rows(turned, samples_at({1}, 0), 2).rows(), 0);
}

TEST(KnownRows, of_both_files_the_first_with_rows_counts) {
  const Samples without = known_rows(list_at({2}), {}, 2);
  const Samples both = joined(joined(without, samples_at({1, 2}, 100)), samples_at({2, 3}, 500));
  const Samples taken = known_rows(list_at({1, 2, 3}), both, 2);
  EXPECT_EQ(taken.rows(), 12);
  EXPECT_EQ(taken.force(4, 0), 120);
  EXPECT_EQ(taken.force(8, 0), 530);
}

TEST(KnownRows, have_every_column_that_either_of_two_files_has) {
  Samples plain = samples_at({1}, 0), rich = samples_at({2}, 0);
  rich.step_check.assign(rich.point.size(), StepCheck::none);
  rich.step_check[1] = StepCheck::falls;
  rich.time_s = Eigen::VectorXd::LinSpaced(rich.rows(), 0, 3);
  rich.lean.setConstant(rich.rows(), 2, 0.25);
  for (const Samples& both : {joined(plain, rich), joined(rich, plain)}) {
    const Samples of_rich = known_rows(list_at({2}), both, 2),
                  of_plain = known_rows(list_at({1}), both, 2);
    ASSERT_EQ(of_rich.step_check.size(), 4u);
    EXPECT_EQ(of_rich.step_check[1], StepCheck::falls);
    EXPECT_EQ(of_rich.time_s, rich.time_s);
    EXPECT_EQ(of_rich.lean, rich.lean);
    EXPECT_EQ(of_plain.step_check[1], StepCheck::none);
    EXPECT_TRUE(of_plain.time_s.array().isNaN().all());
    EXPECT_TRUE(of_plain.lean.isZero());
  }
}

TEST(KnownRows, how_the_surface_moved_goes_with_the_rows_and_is_dropped_where_some_lack_it) {
  Samples kept = samples_at({1, 2}, 0), more = samples_at({3}, 100);
  const auto fill = [](Samples& samples, float from) {
    samples.surface.resize(samples.rows(), 6);
    for (Eigen::Index i = 0; i < samples.surface.size(); ++i)
      samples.surface.data()[i] = from + static_cast<float>(i);
  };
  fill(kept, 0);
  fill(more, 1000);
  const Samples taken = known_rows(list_at({2, 1}), kept, 2);
  ASSERT_EQ(taken.surface.rows(), taken.rows());
  EXPECT_EQ(taken.surface.row(0), kept.surface.row(4));
  const Samples both = joined(kept, more);
  ASSERT_EQ(both.surface.rows(), 12);
  EXPECT_EQ(both.surface.row(8), more.surface.row(0));
  EXPECT_EQ(joined(kept, known_rows(list_at({7}), {}, 2)).surface, kept.surface);
  EXPECT_EQ(joined(kept, samples_at({3}, 0)).surface.rows(), 0);
  EXPECT_EQ(joined(samples_at({3}, 0), kept).surface.rows(), 0);
}

// Of a missing column count, rows were once written beyond a matrix without columns.
TEST(KnownRows, of_one_kind_keep_how_their_surface_moved) {
  Samples all = samples_at({1, 2}, 0);
  all.surface = SurfaceMotion::Random(all.rows(), 600);
  const Samples drags = of_kinds(all, {ExperimentKind::drag});
  ASSERT_EQ(drags.surface.cols(), 600);
  EXPECT_EQ(drags.surface.row(3), all.surface.row(7));
}

TEST(KnownRows, beyond_a_list_are_those_that_it_does_not_hold) {
  const Samples left = beyond(samples_at({1, 2, 3}, 0), list_at({2, 7}));
  EXPECT_EQ(without_rows(list_at({1, 2, 3}), known_rows(list_at({1, 2, 3}), left, 2), 2),
            Numbers{1});
}

TEST(KnownRows, of_a_place_that_is_pressed_alone_and_dragged_too_are_told_apart) {
  Samples pressed = samples_at({1, 2}, 0);
  std::fill(pressed.kind.begin(), pressed.kind.end(), ExperimentKind::press);
  const Samples both = joined(pressed, samples_at({2, 3}, 500));
  const auto at = [](bool is_dragged) {
    return experiments_at(points_at({1, 2, 3}), {3, Effort{is_dragged, 0}});
  };
  EXPECT_EQ(without_rows(at(false), known_rows(at(false), both, 2), 2), Numbers{2});
  EXPECT_EQ(without_rows(at(true), known_rows(at(true), both, 2), 2), Numbers{0});
  const Samples left = beyond(both, experiments_at(points_at({2, 3}), {2, Effort{true, 0}}));
  EXPECT_EQ(left.rows(), 8);  // 1 and 2, pressed alone
  EXPECT_EQ(std::count(left.kind.begin(), left.kind.end(), ExperimentKind::drag), 0);
}

TEST(KnownRows, of_presses_on_one_mesh_are_used_again_under_the_same_factor_alone) {
  Samples quick = samples_at({1, 2}, 0);
  std::fill(quick.kind.begin(), quick.kind.end(), ExperimentKind::press);
  quick.point_scale = Eigen::Vector2d(0.98, 0);
  const auto at = [](const std::vector<Effort>& effort) {
    return experiments_at(points_at({1, 2}), effort);
  };
  const ExperimentList wanted = at({{false, 0.98}, {}}), other = at({{false, 0.97}, {false, 0.98}});
  const Samples same = known_rows(wanted, quick, 2);
  EXPECT_TRUE(without_rows(wanted, same, 2).empty());
  EXPECT_EQ(same.point_scale, quick.point_scale);
  EXPECT_EQ(without_rows(other, known_rows(other, quick, 2), 2), (Numbers{0, 1}));
  EXPECT_EQ(joined(same, quick).point_scale, (Eigen::Vector4d{0.98, 0, 0.98, 0}));
}

// Two pairs, a timed path and a cycle; the second pair stands where its list says.
ExperimentList some_of_each(double second_at) {
  ToolPath path{0, Points::Constant(2, 3, 0.5)};
  ToolPath pair = path;
  pair.second = SecondTool{Vec3(second_at, 1, 0), Vec3(0, 0, -1), Points::Constant(2, 3, 0.25)};
  ToolPath timed{1, Points::Constant(2, 3, 0.5), Eigen::Vector2d(0.1, 0.2)};
  ExperimentList out =
      paths_at(points_at({1, 2}), {pair, {1, path.deflections}}, ExperimentKind::pair);
  append(out, paths_at(points_at({1, 2}), {timed}));
  append(out, paths_at(points_at({1, 2}), {path}, ExperimentKind::cycle));
  return out;
}

TEST(KnownRows, of_paths_are_those_with_the_same_tools_places_and_times) {
  const ExperimentList list = some_of_each(5);
  EXPECT_EQ(list.places.position.rows(), 3) << "a place of two experiments comes once";
  const Samples rows = planned_rows(list);
  const Samples taken = known_rows(list, joined(planned_rows(some_of_each(6)), rows), 2);
  EXPECT_EQ(taken.point, rows.point);
  EXPECT_EQ(taken.experiment, rows.experiment);
  EXPECT_EQ(taken.tool, rows.tool);
  const ExperimentList moved = some_of_each(5.5);
  EXPECT_EQ(without_rows(moved, known_rows(moved, rows, 2), 2), Numbers{0}) << "the pair alone";
  ExperimentList later = list;
  later.experiments[2].path.time_s[1] = 0.3;
  EXPECT_EQ(without_rows(later, known_rows(later, rows, 2), 2), Numbers{2});
  ExperimentList other = list;
  other.experiments[3].kind = ExperimentKind::tool;
  EXPECT_EQ(without_rows(other, known_rows(other, rows, 2), 2), Numbers{3});
  other = list;
  other.experiments[3].probe_number = 1;
  EXPECT_EQ(without_rows(other, known_rows(other, rows, 2), 2), Numbers{3});
}

TEST(PlannedRows, come_back_as_the_list_that_they_were_planned_for) {
  ExperimentList list = some_of_each(5);
  Experiment& one = list.experiments[3];
  one.path.lean = {0.1, 0.2}, one.path.kind = PathKind::sliding, one.probe_number = 2;
  append(list, experiments_at(points_at({4, 5}), {Effort{true, 0}, Effort{false, 0.9}}));
  const ExperimentList back = list_of(planned_rows(list));
  ASSERT_EQ(back.size(), list.size());
  EXPECT_TRUE(without_rows(back, known_rows(back, planned_rows(list), 2), 2).empty());
  EXPECT_EQ(back.places.name, list.places.name);
  EXPECT_EQ(back.experiments[3].path.kind, PathKind::sliding);
  EXPECT_EQ(back.experiments[5].effort.scale, 0.9);
}

// Shards that press and cycle at one place say each its own of it; one process has the first one's.
TEST(KnownRows, of_a_place_in_two_files_the_first_experiment_tells_how_it_sways) {
  const ExperimentList list = some_of_each(5);
  Samples a = planned_rows(taken(list, {0, 2})), b = planned_rows(taken(list, {1, 3}));
  a.point_sway.setConstant(a.points(), 6, 1);
  b.point_sway.setConstant(b.points(), 6, 2);
  for (const Samples& both : {joined(a, b), joined(b, a)}) {
    const Samples known = known_rows(list, both, 2);
    EXPECT_EQ(known.point_sway(list.experiments[0].place, 0), 1);
    EXPECT_EQ(known.point_sway(list.experiments[1].place, 0), 2);
  }
}

TEST(KnownRows, of_some_kinds_keep_their_places_and_lose_columns_that_say_nothing) {
  const Samples rows = planned_rows(some_of_each(5));
  const Samples pair = of_kinds(rows, {ExperimentKind::pair});
  EXPECT_EQ(pair.points(), 3);
  EXPECT_EQ(pair.time_s.size(), 0);
  EXPECT_EQ(pair.tool.size(), 6u);
  const Samples path = of_kinds(rows, {ExperimentKind::path});
  EXPECT_EQ(path.points(), 1);
  EXPECT_EQ(path.point_position(0, 0), 2);
  EXPECT_EQ(path.time_s, Eigen::Vector2d(0.1, 0.2));
  EXPECT_TRUE(path.tool.empty());
}

}  // namespace
}  // namespace palpate
