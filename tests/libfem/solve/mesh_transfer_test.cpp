// What one mesh knows at the nodes of another, and what a search gains by it.

#include "libfem/solve/experiments/simulator_state.hpp"

#include <gtest/gtest.h>

#include "block.hpp"
#include "libfem/solve/equilibrium/path_follower.hpp"

namespace palpate::fem {
namespace {

QuadraticMesh graded_block(const SimulationSetup& setup, double size_m) {
  GradeOptions grade;
  grade.path = {{block_top(), block_top(), size_m, 0}};
  grade.growth = 0.8;
  return grade_mesh(setup.volume, setup.is_held, SmoothSurface(setup.surface), grade);
}

Points parabolas(const Points& nodes) {
  Points out(nodes.rows(), 3);
  for (Eigen::Index n = 0; n < nodes.rows(); ++n) {
    const Vec3 x = nodes.row(n);
    out.row(n) << x.x() * x.z(), x.z() * x.z() - x.y() * x.x(), x.y() * x.y() + x.z();
  }
  return out;
}

TEST(MeshTransfer, is_exact_for_parabolas_and_leaves_what_is_held) {
  const SimulationSetup setup = block_setup(0);
  const QuadraticMesh coarse = graded_block(setup, 0.008), fine = graded_block(setup, 0.003);
  ASSERT_GT(fine.nodes.rows(), 2 * coarse.nodes.rows());
  const Points found = transferred({{parabolas(coarse.nodes)}}, coarse, fine)[0][0],
               wanted = parabolas(fine.nodes);
  for (Eigen::Index n = 0; n < found.rows(); ++n) {
    if (fine.is_held[n])
      EXPECT_EQ(found.row(n).norm(), 0) << n;
    else
      EXPECT_LT((found.row(n) - wanted.row(n)).norm(), 1e-12) << n;
  }
}

struct Dragged {
  std::vector<PathRow> rows;
  Waypoints reached;
  SolverCounts counts;
};

// Presses by 3 mm and drags by 6.
Dragged drag(const QuadraticMesh& mesh, const SimulationSetup& setup, const Waypoints& ahead) {
  const Probe probe = make_probe(setup.probe, "test");
  EquilibriumOptions options;
  options.residual = 1e-5;
  Equilibrium equilibrium(mesh, {make_material(setup.materials[0], "test")}, nullptr, probe, {},
                          options);
  ProbePath press, aside{0, 2, {}};
  for (int k = 1; k <= 3; ++k) press.targets.push_back({Vec3(0, 0, -1e-3 * k), k - 1, true});
  for (int k = 1; k <= 4; ++k) aside.targets.push_back({Vec3(1.5e-3 * k, 0, -3e-3), k + 2, false});
  Dragged out;
  out.rows = follow_paths(equilibrium, probe, {block_top(), -Vec3::UnitZ()}, {press, aside}, 7,
                          true, {}, {}, ahead, &out.reached);
  out.counts = equilibrium.counts();
  return out;
}

void expect_same_forces(const Dragged& guided, const Dragged& alone) {
  for (std::size_t row = 0; row < alone.rows.size(); ++row) {
    ASSERT_EQ(alone.rows[row].status, RowStatus::good) << row;
    ASSERT_EQ(guided.rows[row].status, RowStatus::good) << row;
    EXPECT_LT((guided.rows[row].force_N - alone.rows[row].force_N).norm(),
              5e-4 * alone.rows[row].force_N.norm())
        << row;
  }
}

TEST(MeshTransfer, of_a_coarse_grid_shortens_the_search_and_changes_no_force) {
  const SimulationSetup setup = block_setup(0.3);
  const QuadraticMesh coarse = graded_block(setup, 0.005), fine = graded_block(setup, 0.003);
  const Dragged first = drag(coarse, setup, {}), alone = drag(fine, setup, {}),
                guided = drag(fine, setup, transferred(first.reached, coarse, fine));
  expect_same_forces(guided, alone);
  EXPECT_LT(guided.counts.model, 0.9 * alone.counts.model);
}

// A path that was given up on the other mesh tells nothing from there on.
TEST(MeshTransfer, goes_on_alone_where_the_other_mesh_gave_up) {
  const SimulationSetup setup = block_setup(0.3);
  const QuadraticMesh mesh = graded_block(setup, 0.005);
  const Dragged whole = drag(mesh, setup, {});
  Waypoints ahead = whole.reached;
  ahead[0].back() = {};  // where the drag begins
  ahead[1][1] = ahead[1][3] = {};
  expect_same_forces(drag(mesh, setup, ahead), whole);
}

// A search that was led astray begins again from where the body is.
TEST(MeshTransfer, that_misleads_costs_time_alone) {
  const SimulationSetup setup = block_setup(0.3);
  const QuadraticMesh mesh = graded_block(setup, 0.005);
  const Dragged whole = drag(mesh, setup, {});
  for (const double factor : {-3.0, 8.0}) {
    Waypoints ahead = whole.reached;
    for (auto& path : ahead)
      for (Points& u : path) u *= factor;
    SCOPED_TRACE(factor);
    expect_same_forces(drag(mesh, setup, ahead), whole);
  }
}

}  // namespace
}  // namespace palpate::fem
