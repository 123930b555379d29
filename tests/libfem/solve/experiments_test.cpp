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
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    largest = std::max(largest, a.force.row(i).norm());
    worst = std::max(worst, (a.force.row(i) - factor * b.force.row(i)).norm());
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
    for (Eigen::Index i = 0; i < a.rows(); ++i) {
      ASSERT_EQ(b.status[i], RowStatus::good);
      EXPECT_NEAR((b.force.row(i) - a.force.row(i)).norm(), 0, 1e-6 * a.force.row(i).norm());
    }
  }
}

TEST(PressAndDrag, every_row_on_a_flat_block_is_good) {
  const PointRows& result = with_friction();
  EXPECT_TRUE(result.is_complete);
  ASSERT_EQ(result.rows(), 7);
  for (Eigen::Index row = 0; row < result.rows(); ++row)
    EXPECT_EQ(result.status[row], RowStatus::good)
        << "experiment " << result.experiment[row] << " step " << result.step[row];
}

// Thick layers of Hertz: 4/3 E* sqrt(R d) d is a lower bound on a block held at its bottom, and at
// half an R of depth on 4 R of thickness it is exceeded by less than three times.
TEST(PressAndDrag, press_force_exceeds_hertz_by_no_more_than_the_bottom_explains) {
  for (int i = 0; i < 3; ++i) {
    const double d = with_friction().deflection.row(i).norm();
    const double hertz = 4.0 / 3 * kYoung_Pa / (1 - kPoisson * kPoisson) * std::sqrt(0.008 * d) * d;
    EXPECT_GT(with_friction().force.row(i).dot(kInward), 0.95 * hertz) << d;
    EXPECT_LT(with_friction().force.row(i).dot(kInward), 3 * hertz) << d;
  }
}

TEST(PressAndDrag, drag_pushes_the_body_along_the_motion_and_turns_its_plateau_round) {
  const PointRows& result = with_friction();
  ASSERT_EQ(result.rows(), 7);
  const auto along = [&](Eigen::Index i) { return result.force.row(i).x(); };
  const auto normal = [&](Eigen::Index i) { return result.force.row(i).dot(kInward); };
  for (Eigen::Index i = 3; i < 6; ++i) {
    EXPECT_EQ(result.kind[i], ExperimentKind::drag);
    EXPECT_GT(along(i), i == 3 ? 0.05 * normal(i) : 0.99 * along(i - 1)) << i;
    EXPECT_LT(along(i), normal(i)) << i;
  }
  EXPECT_GT(along(5), 0.8 * kFriction * normal(5)) << "no plateau";
  EXPECT_NEAR(result.deflection(6, 0), 0, 1e-12);
  EXPECT_NEAR(along(6) / normal(6), -along(5) / normal(5), 0.1 * kFriction);
}

TEST(PressAndDrag, drag_without_friction_costs_almost_nothing_on_a_flat_block) {
  const PointRows result = run(block_setup(0));
  for (Eigen::Index i = 3; i < result.rows(); ++i) {
    ASSERT_EQ(result.status[i], RowStatus::good);
    EXPECT_LT((result.force.row(i).transpose() - kInward * kInward.dot(result.force.row(i))).norm(),
              0.05 * result.force.row(i).norm())
        << "step " << result.step[i];
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
  for (Eigen::Index row = 0; row < large.rows(); ++row)
    EXPECT_EQ(large.status[row], RowStatus::good);
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
  for (Eigen::Index row = 0; row < result.rows(); ++row) {
    ASSERT_EQ(result.status[row], RowStatus::good);
    EXPECT_GT(result.force_error[row], 0);
    EXPECT_LT(result.force_error[row], 0.2 * result.force.row(row).norm());
  }
  EXPECT_LT(result.cost.coarse_nodes, result.cost.nodes);
  EXPECT_TRUE(std::isnan(with_friction().force_error[0])) << "no coarse grid, no estimate";
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
  ASSERT_EQ(quick.rows(), 7);
  for (Eigen::Index i = 0; i < quick.rows(); ++i) {
    ASSERT_EQ(quick.status[i], RowStatus::good) << i;
    const bool is_press = quick.kind[i] == ExperimentKind::press;
    EXPECT_LT((quick.force.row(i) - both.force.row(i)).norm(), 0.02 * both.force.row(i).norm())
        << i;
    EXPECT_EQ(quick.force_error[i] > 0.015 * quick.force.row(i).norm(), !is_press) << i;
    EXPECT_LT((quick.torque.row(i) - both.torque.row(i)).norm(),
              0.02 * 0.008 * both.force.row(i).norm())
        << i;
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
  ASSERT_EQ(cheap.rows(), 6) << "without those of the press";
  for (Eigen::Index i = 0; i < cheap.rows(); ++i) {
    ASSERT_EQ(cheap.status[i], RowStatus::good) << i;
    EXPECT_EQ(cheap.kind[i], ExperimentKind::path);
    EXPECT_LT((cheap.force.row(i) - dear.force.row(i)).norm(), cheap.force_error[i]) << i;
    EXPECT_LT((cheap.torque.row(i) - dear.torque.row(i)).norm(),
              0.02 * 0.008 * dear.force.row(i).norm())
        << i;
    EXPECT_GT(cheap.force_error[i], 0.014 * cheap.force.row(i).norm()) << i;
    EXPECT_LT(cheap.force_error[i], 0.03 * cheap.force.row(i).norm()) << i;
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
  const double before = achieved_error(plain);
  ASSERT_GT(before, 0.012);

  setup.options.force_tolerance = 1.01 * before;
  const PointRows same = Simulator(setup).press_and_drag(block_top(), kInward, press_only(1));
  EXPECT_EQ(same.cost.nodes, plain.cost.nodes);
  EXPECT_EQ(same.force.row(same.rows() - 1), plain.force.row(plain.rows() - 1));

  setup.options.force_tolerance = 0.7 * before;
  const PointRows finer = Simulator(setup).press_and_drag(block_top(), kInward, press_only(1));
  EXPECT_LT(achieved_error(finer), 0.7 * before);
  EXPECT_GT(finer.cost.nodes, 3 * plain.cost.nodes / 2);
  EXPECT_EQ(finer.cost.coarse_nodes, plain.cost.nodes);
  for (Eigen::Index i = 0; i < plain.rows(); ++i)
    EXPECT_LT((finer.force.row(i) - plain.force.row(i)).norm(),
              finer.force_error[i] + plain.force_error[i]);
}

TEST(PressAndDrag, a_force_error_that_is_asked_for_is_met_with_what_the_base_mesh_hides) {
  SimulationSetup setup = block_setup(0);
  setup.options.coarse_ratio = 1.6;
  setup.options.max_base_error = 1;  // what the base mesh hides is stated, not halved
  setup.options.element_size = setup.options.growth = SolverOptions{}.growth;
  const double before =
      achieved_error(Simulator(setup).press_and_drag(block_top(), kInward, press_only(2)));
  setup.options.force_tolerance = 0.9 * before;
  EXPECT_LT(achieved_error(Simulator(setup).press_and_drag(block_top(), kInward, press_only(2))),
            0.9 * before);
}

}  // namespace
}  // namespace palpate::fem
