#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "block.hpp"
#include "tests/validation/record.hpp"

namespace palpate::fem {
namespace {

/// An experiment whose truth is a run on a much finer mesh. None of them chose a factor of the
/// error.
struct Case {
  const char* name;
  SimulationSetup setup;
  Vec3 place, normal;
  Experiments experiments;
};

std::vector<Case> cases() {
  Experiments press;
  press.depth_m = 0.005;
  press.press_steps = 6;
  Experiments drag = press_and_one_drag();
  drag.drag_steps = 5;
  std::vector<Case> out;
  SimulationSetup block = block_setup(0);
  block.materials[0].values[1] = 0.48;
  out.push_back({"press", block, Vec3(0.0272, 0.0335, 0.03), -Vec3::UnitZ(), press});
  out.push_back(
      {"press near an edge", block_setup(0.2), Vec3(0.012, 0.021, 0.03), -Vec3::UnitZ(), press});
  out.push_back({"press and drag", block_setup(0.25), block_top(), -Vec3::UnitZ(), drag});
  // Balls of 5 and 6.5 mm, their tops 4 mm under the surface; a layer on the top.
  const auto lump = [&](const char* name, double stiffness, const Vec3& middle, double radius_m) {
    SimulationSetup setup = block_setup(0);
    setup.materials.push_back({"neo-hookean", {stiffness * kYoung_Pa, kPoisson}});
    setup.region_at = [=](const Vec3& x) { return (x - middle).norm() < radius_m; };
    out.push_back({name, setup, Vec3(0.033, 0.029, 0.03), -Vec3::UnitZ(), press});
  };
  lump("over a stiff lump", 10, {0.03, 0.03, 0.021}, 0.005);
  lump("over a soft lump", 0.1, {0.03, 0.03, 0.021}, 0.005);
  lump("over a hard lump", 100, {0.035, 0.025, 0.0185}, 0.0065);
  lump("under a stiff skin", 5, {0.03, 0.03, 10.0265}, 10);
  return out;
}

/// Finer by 1.5, itself extrapolated with a coarse grid: its own error is a third of the run's and
/// less.
SolverOptions truth_options() {
  SolverOptions options;
  options.element_size = options.growth = 0.33;
  options.coarse_ratio = 1.5;
  return options;
}

TEST(ValidationForceError, bounds_the_true_error_in_nineteen_rows_of_twenty_and_not_tenfold) {
  int rows = 0, covered = 0;
  double worst = 0, squares = 0, bounds = 0;
  const double start = validation::cpu_seconds();
  for (Case& c : cases()) {
    c.setup.options = SolverOptions{};
    const PointRows ours = Simulator(c.setup).press_and_drag(c.place, c.normal, c.experiments);
    c.setup.options = truth_options();
    const PointRows truth = Simulator(c.setup).press_and_drag(c.place, c.normal, c.experiments);
    for (Eigen::Index i = 0; i < ours.rows(); ++i) {
      ASSERT_EQ(ours.status[i], RowStatus::good) << c.name << " row " << i;
      ASSERT_EQ(truth.status[i], RowStatus::good) << c.name << " row " << i;
      const double size = truth.force.row(i).norm(),
                   error = (ours.force.row(i) - truth.force.row(i)).norm() / size;
      const double bound = ours.force_error[i] / size;
      std::printf("%-20s %d/%d: error %.2f %%, bound %.2f %%\n", c.name, ours.experiment[i],
                  ours.step[i], 100 * error, 100 * bound);
      ++rows;
      covered += error <= bound;
      worst = std::max(worst, error);
      squares += error * error;
      bounds += bound;
    }
  }
  const double coverage = double(covered) / rows, rms = std::sqrt(squares / rows);
  std::printf("%d of %d rows within their error; rms %.2f %%, worst %.2f %%, mean bound %.2f %%\n",
              covered, rows, 100 * rms, 100 * worst, 100 * bounds / rows);
  EXPECT_GE(coverage, 0.95);
  EXPECT_LT(worst, 0.02);
  EXPECT_LT(bounds / rows, 10 * rms);
  validation::record_case("FORCE_ERROR/coverage", 0.95, coverage, "", coverage / 0.95 - 1,
                          validation::cpu_seconds() - start);
}

}  // namespace
}  // namespace palpate::fem
