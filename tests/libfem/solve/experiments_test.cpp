#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "block.hpp"
#include "libfem/solve/equilibrium/equilibrium.hpp"

namespace palpate::fem {
namespace {

const Vec3 kInward = -Vec3::UnitZ();
constexpr double kFriction = 0.3;

PointRows run(const SimulationSetup& setup, double scale = 1, const Vec3& moved = Vec3::Zero()) {
  return Simulator(setup).press_and_drag(block_top(scale) + moved, kInward,
                                         press_and_one_drag(scale));
}

/// The reference run, made once.
const PointRows& with_friction() {
  static const PointRows rows = run(block_setup(kFriction));
  return rows;
}

/// Greatest difference of force between runs, over the greatest force.
double difference(const PointRows& a, const PointRows& b, double factor = 1) {
  double largest = 0, worst = 0;
  for (std::size_t i = 0; i < a.rows.size(); ++i) {
    largest = std::max(largest, a.rows[i].force.norm());
    worst = std::max(worst, (a.rows[i].force - factor * b.rows[i].force).norm());
  }
  return worst / largest;
}

// A slot that the ball just fits into, or that is 0.2 mm too narrow for it: its far wall, behind
// the ball, is not what the press is of.
TEST(PressAndDrag, what_stands_behind_the_tool_is_not_met) {
  const SimulationSetup alone = block_setup(0.2);
  const auto pressed = [](const SimulationSetup& setup) {
    return Simulator(setup).press_and_drag(block_top(), kInward, press_only(3));
  };
  const PointRows a = pressed(alone);
  for (const double far_wall_m : {0.05, 0.0458}) {
    SimulationSetup slot = alone;
    const auto nodes = static_cast<std::int32_t>(alone.volume.nodes.rows());
    const Eigen::Index tets = alone.volume.tets.rows();
    slot.volume.nodes.resize(2 * nodes, 3);
    slot.volume.nodes << alone.volume.nodes,
        alone.volume.nodes.rowwise() + Eigen::RowVector3d(0, 0, far_wall_m);
    slot.volume.tets.resize(2 * tets, 4);
    slot.volume.tets << alone.volume.tets, alone.volume.tets.array() + nodes;
    for (const auto& x : alone.volume.nodes.rowwise()) slot.is_held.push_back(x.z() > 0.03 - 1e-6);
    slot.surface = {slot.volume.nodes, boundary_triangles(slot.volume.tets)};
    const PointRows b = pressed(slot);
    EXPECT_NEAR(b.touch_offset_m, 0, 1e-9);
    for (std::size_t i = 0; i < a.rows.size(); ++i) {
      ASSERT_EQ(b.rows[i].status, RowStatus::good);
      EXPECT_NEAR((b.rows[i].force - a.rows[i].force).norm(), 0, 1e-6 * a.rows[i].force.norm());
    }
  }
}

TEST(PressAndDrag, every_row_on_a_flat_block_is_good) {
  const PointRows& result = with_friction();
  EXPECT_TRUE(result.is_complete);
  EXPECT_NEAR(result.touch_offset_m, 0, 1e-9);
  ASSERT_EQ(result.rows.size(), 7u);
  for (const PointRow& row : result.rows)
    EXPECT_EQ(row.status, RowStatus::good)
        << "experiment " << row.experiment << " step " << row.step;
}

// Thick layers of Hertz: 4/3 E* sqrt(R d) d is a lower bound on a block held at its bottom, and at
// half an R of depth on 4 R of thickness it is exceeded by less than three times.
TEST(PressAndDrag, press_force_exceeds_hertz_by_no_more_than_the_bottom_explains) {
  for (int i = 0; i < 3; ++i) {
    const PointRow& row = with_friction().rows[i];
    const double d = row.deflection.norm();
    const double hertz = 4.0 / 3 * kYoung_Pa / (1 - kPoisson * kPoisson) * std::sqrt(0.008 * d) * d;
    EXPECT_GT(row.force.dot(kInward), 0.95 * hertz) << d;
    EXPECT_LT(row.force.dot(kInward), 3 * hertz) << d;
  }
}

TEST(PressAndDrag, drag_pushes_the_body_along_the_motion_and_reaches_a_plateau) {
  const PointRows& result = with_friction();
  double before = 0;
  for (std::size_t i = 3; i < result.rows.size(); ++i) {
    const PointRow& row = result.rows[i];
    EXPECT_EQ(row.kind, ExperimentKind::drag);
    const Vec3 lateral = row.deflection - kInward * kInward.dot(row.deflection);
    const double along = row.force.dot(lateral.normalized()), normal = row.force.dot(kInward);
    EXPECT_GT(along, 0.99 * before) << "step " << row.step;
    EXPECT_LT(along, normal) << "step " << row.step;
    EXPECT_GT(along, 0.05 * normal) << "step " << row.step;
    before = along;
  }
  const auto along = [&](std::size_t i) { return result.rows[i].force.x(); };
  EXPECT_LT(along(6) - along(5), 0.15 * (along(3))) << "no plateau";
  EXPECT_GT(along(6), 0.8 * kFriction * result.rows[6].force.dot(kInward));
}

TEST(PressAndDrag, drag_without_friction_costs_almost_nothing_on_a_flat_block) {
  const PointRows result = run(block_setup(0));
  for (std::size_t i = 3; i < result.rows.size(); ++i) {
    const PointRow& row = result.rows[i];
    ASSERT_EQ(row.status, RowStatus::good);
    EXPECT_LT((row.force - kInward * kInward.dot(row.force)).norm(), 0.05 * row.force.norm())
        << "step " << row.step;
  }
}

// Rounding may let one solve stop an iteration earlier, so runs agree to a fraction of its
// tolerance: that is made small enough to tell.
constexpr double kSameRun = 1e-6;

SimulationSetup tight_block(double scale = 1) {
  SimulationSetup setup = block_setup(kFriction, scale);
  setup.options.equilibrium.residual = 1e-8;
  return setup;
}

const PointRows& tight_run() {
  static const PointRows rows = run(tight_block());
  return rows;
}

TEST(PressAndDrag, force_over_modulus_and_area_does_not_know_the_unit_of_length) {
  constexpr double kScale = 1e3, kSofter = 1e-6;
  SimulationSetup setup = tight_block(kScale);
  setup.materials[0].values[0] *= kSofter;
  const PointRows large = run(setup, kScale);
  for (const PointRow& row : large.rows) EXPECT_EQ(row.status, RowStatus::good);
  EXPECT_LT(difference(tight_run(), large, 1 / (kScale * kScale * kSofter)), kSameRun);
}

TEST(PressAndDrag, forces_do_not_depend_on_where_the_body_is) {
  const Vec3 away(60, -45, 30);  // a thousand body lengths
  SimulationSetup setup = tight_block();
  setup.volume.nodes.rowwise() += away.transpose();
  setup.surface.vertices.rowwise() += away.transpose();
  EXPECT_LT(difference(tight_run(), run(setup, 1, away)), kSameRun);
}

TEST(PressAndDrag, the_coarse_grid_gives_a_finite_error_of_a_few_percent) {
  SimulationSetup setup = block_setup(0);
  setup.options.coarse_ratio = SolverOptions{}.coarse_ratio;
  setup.options.element_size = setup.options.growth = SolverOptions{}.growth;
  const PointRows result = Simulator(setup).press_and_drag(block_top(), kInward, press_only(2));
  for (const PointRow& row : result.rows) {
    ASSERT_EQ(row.status, RowStatus::good);
    EXPECT_GT(row.force_error, 0);
    EXPECT_LT(row.force_error, 0.2 * row.force.norm());
  }
  EXPECT_LT(result.cost.coarse_nodes, result.cost.nodes);
  EXPECT_TRUE(std::isnan(with_friction().rows[0].force_error)) << "no coarse grid, no estimate";
}

TEST(Equilibrium, force_and_torque_of_the_probe_balance_the_ground_to_the_tolerance_of_the_solver) {
  SimulationSetup setup = block_setup(kFriction);
  setup.materials[0].values[1] = 0.49;
  GradeOptions grade;
  grade.path = {{block_top(), block_top()}};
  const QuadraticMesh mesh =
      grade_mesh(setup.volume, setup.is_held, SmoothSurface(setup.surface), grade);
  for (const double tolerance : {1e-3, 1e-7}) {
    SCOPED_TRACE(testing::Message() << "to " << tolerance);
    EquilibriumOptions options;
    options.residual = tolerance;
    Equilibrium equilibrium(mesh, {make_material(setup.materials[0], "test")}, nullptr,
                            make_probe(setup.probe, "test"), {}, options);
    BodyState at = equilibrium.rest({block_top(), kInward}), next;
    // Down and to the side, in steps.
    for (const Vec3& by : {Vec3(0, 0, -0.001), Vec3(0, 0, -0.002), Vec3(0.0005, 0, -0.002)}) {
      const ProbePose pose{block_top() + by, kInward};
      ASSERT_TRUE(equilibrium.solve(at, pose, at.u, next)) << by.transpose();
      at = next;
      const Vec3 force = at.contact.force_N;
      Points of_ground = Points::Zero(at.u.rows(), 3);
      equilibrium.body().add_force(at.u, of_ground);
      Vec3 left_N = force, left_Nm = at.contact.torque_Nm;
      for (Eigen::Index n = 0; n < at.u.rows(); ++n) {
        if (!mesh.is_held[n]) continue;
        const Vec3 arm = (mesh.nodes.row(n) + at.u.row(n)).transpose() - pose.tip;
        left_N += of_ground.row(n).transpose();
        left_Nm += arm.cross(Vec3(of_ground.row(n)));
      }
      EXPECT_LT(left_N.norm(), 10 * tolerance * force.norm());
      EXPECT_LT(left_Nm.norm(), 10 * tolerance * force.norm() * 0.03) << "block of 30 mm";
    }
    EXPECT_GT(at.contact.force_N.x(), 0);
  }
}

// (M13k), which needs no fine mesh, against both meshes, which a tolerance asks for.
TEST(PressAndDrag, a_drag_on_the_coarse_grid_times_the_factor_of_its_press_is_that_on_both) {
  SimulationSetup setup = block_setup(kFriction);
  setup.options.coarse_ratio = 1.6;
  setup.options.element_size = setup.options.growth = SolverOptions{}.growth;
  const PointRows quick = run(setup);
  setup.options.force_tolerance = 0.5;  // no finer mesh
  const PointRows both = run(setup);
  ASSERT_EQ(quick.rows.size(), 7u);
  for (std::size_t i = 0; i < quick.rows.size(); ++i) {
    const PointRow &row = quick.rows[i], &other = both.rows[i];
    ASSERT_EQ(row.status, RowStatus::good) << i;
    const bool is_press = row.kind == ExperimentKind::press;
    EXPECT_LT((row.force - other.force).norm(), 0.02 * other.force.norm()) << i;
    EXPECT_EQ(row.force_error > 0.015 * row.force.norm(), !is_press) << i;
    EXPECT_LT((row.torque - other.torque).norm(), 0.02 * 0.008 * other.force.norm()) << i;
  }
  EXPECT_LT(2 * quick.cost.solver.newton, both.cost.solver.newton);
}

TEST(Paths, on_the_coarse_grid_times_the_factor_of_a_press_are_those_on_both) {
  SimulationSetup setup = block_setup(kFriction);
  setup.options.coarse_ratio = 1.6;
  setup.options.element_size = setup.options.growth = SolverOptions{}.growth;
  SimulationSetup exact = setup;
  exact.options.force_tolerance = 0.5;  // no finer mesh, but both grids
  const Simulator quick(setup), both(exact);
  const auto follow = [](const Simulator& by, const Points& way) {
    return by.follow(block_top(), kInward, {0, way});
  };
  Points turning(6, 3);
  turning << 0, 0, -0.002, 0, 0, -0.004, 0.002, 0, -0.0035, 0.004, 0, -0.003, 0.003, 0.002, -0.003,
      0.001, 0.003, -0.0035;
  const PointRows cheap = follow(quick, turning), dear = follow(both, turning);
  ASSERT_EQ(cheap.rows.size(), 6u) << "without those of the press";
  for (std::size_t i = 0; i < cheap.rows.size(); ++i) {
    const PointRow &row = cheap.rows[i], &other = dear.rows[i];
    ASSERT_EQ(row.status, RowStatus::good) << i;
    EXPECT_EQ(row.kind, ExperimentKind::path);
    EXPECT_LT((row.force - other.force).norm(), row.force_error) << i;
    EXPECT_LT((row.torque - other.torque).norm(), 0.02 * 0.008 * other.force.norm()) << i;
    EXPECT_GT(row.force_error, 0.014 * row.force.norm()) << i;
    EXPECT_LT(row.force_error, 0.03 * row.force.norm()) << i;
  }
  EXPECT_LT(2 * cheap.cost.solver.newton, dear.cost.solver.newton);
  EXPECT_EQ(difference(follow(quick, turning.topRows(2)), follow(both, turning.topRows(2))), 0)
      << "a straight press is on both";
}

TEST(PressAndDrag, a_force_error_that_is_asked_for_is_met_on_a_finer_mesh) {
  SimulationSetup setup = block_setup(0);
  setup.options.coarse_ratio = 1.6;
  setup.options.element_size = 1.2;  // less than an element under the contact: far from the
  setup.options.shallowest = 1;      // least error
  setup.options.growth = SolverOptions{}.growth;
  setup.options.max_base_error = 0;
  setup.materials[0].values[1] = 0.49;
  const PointRows plain = Simulator(setup).press_and_drag(block_top(), kInward, press_only(1));
  const double before = achieved_error(plain.rows);
  ASSERT_GT(before, 0.012);

  setup.options.force_tolerance = 1.01 * before;
  const PointRows same = Simulator(setup).press_and_drag(block_top(), kInward, press_only(1));
  EXPECT_EQ(same.cost.nodes, plain.cost.nodes);
  EXPECT_EQ(same.rows.back().force, plain.rows.back().force);

  setup.options.force_tolerance = 0.7 * before;
  const PointRows finer = Simulator(setup).press_and_drag(block_top(), kInward, press_only(1));
  EXPECT_LT(achieved_error(finer.rows), 0.7 * before);
  EXPECT_GT(finer.cost.nodes, 3 * plain.cost.nodes / 2);
  EXPECT_EQ(finer.cost.coarse_nodes, plain.cost.nodes);
  for (std::size_t i = 0; i < plain.rows.size(); ++i)
    EXPECT_LT((finer.rows[i].force - plain.rows[i].force).norm(),
              finer.rows[i].force_error + plain.rows[i].force_error);
}

TEST(PressAndDrag, a_force_error_that_is_asked_for_is_met_with_what_the_base_mesh_hides) {
  SimulationSetup setup = block_setup(0);
  setup.options.coarse_ratio = 1.6;
  setup.options.max_base_error = 1;  // what the base mesh hides is stated, not halved
  setup.options.element_size = setup.options.growth = SolverOptions{}.growth;
  const double before =
      achieved_error(Simulator(setup).press_and_drag(block_top(), kInward, press_only(2)).rows);
  setup.options.force_tolerance = 0.9 * before;
  EXPECT_LT(
      achieved_error(Simulator(setup).press_and_drag(block_top(), kInward, press_only(2)).rows),
      0.9 * before);
}

}  // namespace
}  // namespace palpate::fem
