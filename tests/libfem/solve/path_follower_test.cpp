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

StepCheck checked(const BodyState& before, const BodyState& after, bool must_rise = true) {
  return check_step(before, after, must_rise, kDeepest_m);
}

TEST(JudgeStep, a_press_that_pushes_harder_is_believed) {
  EXPECT_EQ(checked(pressed(0), pressed(0.1)), StepCheck::none);
  EXPECT_EQ(checked(pressed(0.1), pressed(0.2)), StepCheck::none);
}

TEST(JudgeStep, each_check_has_its_own_name) {
  const BodyState before = pressed(0.1);
  BodyState inverted = pressed(0.2), overlaps = inverted, pulls = inverted, no_area = inverted;
  inverted.min_J = 0;
  overlaps.contact.greatest_penetration_m = 1.01 * kDeepest_m;
  pulls.contact.force_N *= -1;
  no_area.contact.area_m2 = 0;
  EXPECT_EQ(checked(before, inverted), StepCheck::inverted);
  EXPECT_EQ(checked(before, overlaps), StepCheck::overlaps);
  EXPECT_EQ(checked(before, pulls), StepCheck::pulls);
  EXPECT_EQ(checked(before, no_area), StepCheck::no_area);
  EXPECT_EQ(checked(before, pressed(0.1)), StepCheck::does_not_rise);
  EXPECT_EQ(checked(before, pressed(0.09)), StepCheck::does_not_rise);
  const std::set<std::string_view> names(kStepCheckNames.begin(), kStepCheckNames.end());
  EXPECT_EQ(names.size(), kStepCheckNames.size());
}

TEST(JudgeStep, a_drag_may_ease_and_may_leave_the_body) {
  EXPECT_EQ(checked(pressed(0.1), pressed(0.05), false), StepCheck::none);
  EXPECT_EQ(checked(pressed(0.1), pressed(0), false), StepCheck::none);
}

TEST(JudgeStep, a_number_that_is_none_is_not_believed) {
  BodyState state = pressed(0.2);
  state.min_J = std::nan("");
  EXPECT_EQ(checked(pressed(0.1), state), StepCheck::inverted);
  state = pressed(0.2);
  state.contact.force_N.setConstant(std::nan(""));
  EXPECT_EQ(checked(pressed(0.1), state), StepCheck::pulls);
}

/// Rows of the press on the block with a penalty, after an Uzawa update or not.
std::vector<PathRow> press(double stiffness, bool uzawa_update, double friction) {
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
  ProbePath path;
  for (int row = 0; row < 3; ++row)
    path.targets.push_back({Vec3(0, 0, -1e-3 * (row + 1)), row, true});
  return follow_paths(equilibrium, probe, {block_top(), -Vec3::UnitZ()}, {path}, 3, uzawa_update);
}

// Without friction what is left is of second order: under a third of the shift on this coarse mesh,
// and within the error that the row owns up to.
TEST(PathFollower, force_after_an_uzawa_update_is_that_of_a_far_stiffer_penalty) {
  const std::vector<PathRow> updated = press(250, true, 0), soft = press(250, false, 0),
                             stiff = press(4000, true, 0);
  for (int row = 0; row < 3; ++row) {
    ASSERT_EQ(updated[row].status, RowStatus::good);
    const double left = (updated[row].force_N - stiff[row].force_N).norm();
    const double bias = (soft[row].force_N - stiff[row].force_N).norm();
    EXPECT_GT(bias, 2e-3 * stiff[row].force_N.norm());
    EXPECT_LT(left, bias / 3) << "row " << row;
    EXPECT_LT(left, updated[row].penalty_error_N + 5e-4 * stiff[row].force_N.norm());
    EXPECT_NEAR((updated[row].force_N - updated[row].penalty_shift_N - soft[row].force_N).norm(), 0,
                1e-4 * soft[row].force_N.norm());
  }
}

}  // namespace
}  // namespace palpate::fem
