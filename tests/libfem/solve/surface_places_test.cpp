// How the fine surface moves with the solved mesh.

#include "libfem/solve/experiments/simulator_state.hpp"

#include <gtest/gtest.h>

#include <random>

#include "block.hpp"
#include "libfem/solve/experiments/simulate.hpp"

namespace palpate::fem {
namespace {

constexpr double kQuantum_m = 1.0 / (1 << 24);

/// One boundary face, its mid-edge nodes halfway.
QuadraticMesh one_face() {
  QuadraticMesh mesh;
  mesh.nodes.resize(6, 3);
  mesh.nodes << 0, 0, 0, 0.01, 0, 0, 0, 0.01, 0, 0.005, 0, 0, 0.005, 0.005, 0, 0, 0.005, 0;
  mesh.faces.resize(1, 6);
  mesh.faces << 0, 1, 2, 3, 4, 5;
  return mesh;
}

TEST(SurfacePlaces, a_node_moves_by_exactly_what_the_solver_says) {
  const QuadraticMesh mesh = one_face();
  const Points up = Vec3::UnitZ().transpose().replicate(6, 1);
  const SurfacePlaces places(mesh, mesh.nodes, up);
  const unsigned seed = 3;
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> draw(-5000, 5000);
  Points u(6, 3);
  for (Eigen::Index i = 0; i < u.size(); ++i) u.data()[i] = draw(random) * kQuantum_m;
  const Eigen::VectorXf moved = places.displacement(u, kQuantum_m);
  for (Eigen::Index i = 0; i < u.size(); ++i) EXPECT_EQ(double(moved[i]), u.data()[i]) << i;
}

TEST(SurfacePlaces, a_quadratic_motion_is_followed_everywhere_on_a_face) {
  const QuadraticMesh mesh = one_face();
  const auto motion = [](const Vec3& x) {
    return Vec3(x[0] * x[1] + 0.2 * x[0], 3 * x[1] * x[1] - x[0], x[0] * x[0]);
  };
  Points u(6, 3);
  for (Eigen::Index i = 0; i < 6; ++i) u.row(i) = motion(mesh.nodes.row(i)).transpose();
  Points at(3, 3);
  at << 0.002, 0.003, 0, 0.001, 0.0005, 0, 0.0045, 0.0045, 0.001;  // the last one above the face
  const Points up = Vec3::UnitZ().transpose().replicate(3, 1);
  const Eigen::VectorXf moved = SurfacePlaces(mesh, at, up).displacement(u, 1e-12);
  for (Eigen::Index i = 0; i < 3; ++i) {
    Vec3 on = at.row(i);
    on[2] = 0;
    EXPECT_LT((moved.segment(3 * i, 3).cast<double>() - motion(on)).norm(), 1e-9) << i;
  }
}

TEST(Simulate, rows_keep_how_the_surface_moves_and_forces_stay_the_same_bits) {
  SimulationSetup setup = block_setup(0.3);
  const Simulator plain(setup);
  setup.keeps_surface = true;
  const Simulator kept(setup);
  const TestPoints points = one_point();
  Experiments experiments = press_and_one_drag();
  experiments.press_steps = 2;
  experiments.drag_steps = 1;
  experiments.drag_distance_m = 0.001;
  const Samples without = simulate(plain, experiments_at(points), experiments, {.jobs = 1});
  const Samples with = simulate(kept, experiments_at(points), experiments, {.jobs = 1});
  EXPECT_EQ(without.surface.rows(), 0);
  EXPECT_EQ(without.force, with.force);
  ASSERT_EQ(with.surface.rows(), with.rows());
  ASSERT_EQ(with.surface.cols(), 3 * setup.surface.vertices.rows());
  // The vertex nearest to the tool goes down about as far as the tool, held ones stay.
  Eigen::Index nearest = 0;
  (setup.surface.vertices.rowwise() - points.position.row(0)).rowwise().norm().minCoeff(&nearest);
  const double offset_m = (setup.surface.vertices.row(nearest) - points.position.row(0)).norm();
  for (Eigen::Index row = 0; row < with.rows(); ++row) {
    const double depth_m = -with.deflection(row, 2);
    const double down_m = -double(with.surface(row, 3 * nearest + 2));
    EXPECT_GT(down_m, 0.75 * depth_m - offset_m) << row;
    EXPECT_LT(down_m, 1.02 * depth_m) << row;
  }
  for (Eigen::Index v = 0; v < setup.surface.vertices.rows(); ++v)
    if (setup.surface.vertices(v, 2) < 1e-9) {
      EXPECT_LT(with.surface.middleCols(3 * v, 3).cwiseAbs().maxCoeff(), 1e-6) << v;
    }
  // Rows that tell nothing of the surface do not take it from those they are joined to: a shard of
  // pairs alone, which no merge could read.
  const Samples blank = simulate(plain, experiments_at(points), experiments,
                                 {.jobs = 1, .surface_columns = with.surface.cols()});
  EXPECT_EQ(blank.force, with.force);
  EXPECT_TRUE(joined(blank, with).surface.bottomRows(with.rows()) == with.surface);
}

}  // namespace
}  // namespace palpate::fem
