#include "libfem/solve/equilibrium/path_follower.hpp"

#include <gtest/gtest.h>

#include <set>

#include "block.hpp"

namespace palpate::fem {
namespace {

constexpr double kDeepest_m = 2e-4;

/// A state that nothing is wrong with: pressed with a force along -z.
BodyState pressed(double force_N) {
  BodyState state;
  state.pose.axis = -Vec3::UnitZ();
  state.contact.force_N = Vec3(0, 0, -force_N);
  state.contact.area_m2 = force_N > 0 ? 1e-5 : 0;
  state.contact.points = force_N > 0 ? 12 : 0;
  state.contact.greatest_penetration_m = kDeepest_m / 2;
  return state;
}

RowDoubt judged(const BodyState& before, const BodyState& after, bool must_rise = true) {
  return judge_step(before, after, must_rise, kDeepest_m);
}

TEST(JudgeStep, a_press_that_pushes_harder_is_believed) {
  EXPECT_EQ(judged(pressed(0), pressed(0.1)), RowDoubt::none);
  EXPECT_EQ(judged(pressed(0.1), pressed(0.2)), RowDoubt::none);
}

TEST(JudgeStep, each_doubt_has_its_own_name) {
  const BodyState before = pressed(0.1);
  BodyState inverted = pressed(0.2), overlaps = inverted, pulls = inverted, no_area = inverted;
  inverted.min_J = 0;
  overlaps.contact.greatest_penetration_m = 1.01 * kDeepest_m;
  pulls.contact.force_N *= -1;
  no_area.contact.area_m2 = 0;
  EXPECT_EQ(judged(before, inverted), RowDoubt::inverted);
  EXPECT_EQ(judged(before, overlaps), RowDoubt::overlaps);
  EXPECT_EQ(judged(before, pulls), RowDoubt::pulls);
  EXPECT_EQ(judged(before, no_area), RowDoubt::no_area);
  EXPECT_EQ(judged(before, pressed(0.1)), RowDoubt::does_not_rise);
  EXPECT_EQ(judged(before, pressed(0.09)), RowDoubt::does_not_rise);
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < kRowDoubtNames.size(); ++i) {
    EXPECT_EQ(static_cast<std::size_t>(kRowDoubtNames[i].doubt), i);
    names.insert(kRowDoubtNames[i].name);
  }
  EXPECT_EQ(names.size(), kRowDoubtNames.size());
}

TEST(JudgeStep, a_drag_may_ease_and_may_leave_the_body) {
  EXPECT_EQ(judged(pressed(0.1), pressed(0.05), false), RowDoubt::none);
  EXPECT_EQ(judged(pressed(0.1), pressed(0), false), RowDoubt::none);
}

TEST(JudgeStep, a_number_that_is_none_is_not_believed) {
  BodyState state = pressed(0.2);
  state.min_J = std::nan("");
  EXPECT_EQ(judged(pressed(0.1), state), RowDoubt::inverted);
  state = pressed(0.2);
  state.contact.force_N.setConstant(std::nan(""));
  EXPECT_EQ(judged(pressed(0.1), state), RowDoubt::pulls);
}

/// Rows of the press on the block with a penalty, its overlap given back or not.
std::vector<TrackRow> press(double stiffness, bool gives_back, double friction) {
  const SimulationSetup setup = block_setup(friction);
  GradeOptions grade;
  grade.path = {{block_top(), block_top(), 0.0025, 0}};
  grade.growth = 0.8;
  const QuadraticMesh mesh =
      grade_mesh(setup.volume, setup.is_held, SmoothSurface(setup.surface), grade);
  const Probe probe = make_probe(setup.probe, "test");
  ContactSettings contact;
  contact.stiffness = stiffness;
  EquilibriumOptions options;
  options.residual = 1e-5;
  Equilibrium equilibrium(mesh, {make_material(setup.materials[0], "test")}, nullptr, probe,
                          contact, options);
  Track track;
  for (int row = 0; row < 3; ++row)
    track.waypoints.push_back({Vec3(0, 0, -1e-3 * (row + 1)), row, true});
  WalkOptions walk;
  walk.gives_back = gives_back;
  return walk_tracks(equilibrium, probe, {block_top(), -Vec3::UnitZ()}, {track}, 3, walk);
}

// Without friction what is left is of second order: under a third of the shift on this coarse mesh,
// and within the error that the row owns up to.
TEST(Tracks, force_with_the_overlap_given_back_is_that_of_a_far_stiffer_penalty) {
  const std::vector<TrackRow> given_back = press(250, true, 0), soft = press(250, false, 0),
                              stiff = press(4000, true, 0);
  for (int row = 0; row < 3; ++row) {
    ASSERT_EQ(given_back[row].status, RowStatus::good);
    const double left = (given_back[row].force_N - stiff[row].force_N).norm();
    const double bias = (soft[row].force_N - stiff[row].force_N).norm();
    EXPECT_GT(bias, 2e-3 * stiff[row].force_N.norm());
    EXPECT_LT(left, bias / 3) << "row " << row;
    EXPECT_LT(left, given_back[row].penalty_error_N + 5e-4 * stiff[row].force_N.norm());
    EXPECT_NEAR(
        (given_back[row].force_N - given_back[row].penalty_shift_N - soft[row].force_N).norm(), 0,
        1e-4 * soft[row].force_N.norm());
  }
}

}  // namespace
}  // namespace palpate::fem
