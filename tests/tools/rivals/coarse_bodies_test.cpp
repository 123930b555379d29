// Coarse bodies answer as the simulator does where their meshes get finer.

#include <gtest/gtest.h>

#include <array>
#include <cstdlib>

#include "libfem/mesh/boundary.hpp"
#include "tests/libfem/solve/block.hpp"
#include "tools/workshop/rivals/bullet_body.hpp"
#include "tools/workshop/rivals/corotational.hpp"
#include "tools/workshop/rivals/mujoco.hpp"
#include "tools/workshop/rivals/rivals.hpp"
#include "tools/workshop/rivals/total_lagrangian.hpp"

namespace palpate::tools {
namespace {

CoarseBody coarse_block(const Mat3& turn, const std::array<int, 3>& cells) {
  const TetMesh mesh = fem::structured_block({0.06, 0.06, 0.03}, cells);
  const Points turned = mesh.nodes * turn.transpose();
  CoarseBody body{turned, mesh.tets, {}, {}, {}, {}};
  for (const auto& node : mesh.nodes.rowwise()) body.is_held.push_back(node[2] < 1e-6);
  body.young_Pa = Eigen::VectorXd::Constant(mesh.tets.rows(), fem::kYoung_Pa);
  body.poisson = Eigen::VectorXd::Constant(mesh.tets.rows(), fem::kPoisson);
  const TetMesh fine = fem::structured_block({0.06, 0.06, 0.03}, {30, 30, 2});
  const Points middle = (turn * fem::block_top()).transpose();
  body.carried = carried_points(turned, mesh.tets,
                                {fine.nodes * turn.transpose(), fem::boundary_triangles(fine.tets)},
                                middle, 0.018);
  return body;
}

constexpr BallContact kBall{
    .radius_m = 8e-3, .friction = 0.3, .penalty_Pa_m = 20e3 * fem::kYoung_Pa};

// Pressed by 2 mm in steps of 40 um, then dragged along x.
template <class Body>
Vec3 press_and_drag(Body& body, const Mat3& turn, double drag_m) {
  const Vec3 above = fem::block_top() + kBall.radius_m * Vec3::UnitZ();
  Vec3 force = Vec3::Zero();
  for (int k = 0; k <= 50; ++k) force = body.force(turn * (above - 4e-5 * k * Vec3::UnitZ()));
  for (int k = 1; k <= 50; ++k)
    force = body.force(turn * (above - 2e-3 * Vec3::UnitZ() + drag_m * k / 50 * Vec3::UnitX()));
  return force;
}

// The simulator's force [N] 2 mm deep.
double simulated_press_N() {
  fem::SimulationSetup setup = fem::block_setup(0.3);
  fem::Experiments experiments = fem::press_only(1);
  experiments.depth_m = 2e-3;
  setup.options.growth = 0.6;
  setup.options.coarse_ratio = 1.6;
  const fem::PointRows rows =
      fem::Simulator(setup).press_and_drag(fem::block_top(), -Vec3::UnitZ(), experiments);
  EXPECT_EQ(rows.rows.at(0).status, RowStatus::good);
  return rows.rows.at(0).force.z();
}

// Stays where the drag of 0 mm ends.
template <class Body>
Vec3 rest_pressed(Body& body, int ticks) {
  Vec3 force = press_and_drag(body, Mat3::Identity(), 0);
  for (int k = 0; k < ticks; ++k)
    force = body.force(fem::block_top() + (kBall.radius_m - 2e-3) * Vec3::UnitZ());
  return force;
}

TEST(Corotational, comes_down_to_the_simulator_as_its_mesh_gets_finer) {
  const double simulated_N = simulated_press_N();
  double before = 10;
  for (const int cells : {6, 12, 20}) {
    CorotationalBody body(coarse_block(Mat3::Identity(), {cells, cells, cells / 2}),
                          {.ball = kBall});
    const double ratio = press_and_drag(body, Mat3::Identity(), 0).z() / simulated_N;
    EXPECT_LT(ratio, before) << cells;
    EXPECT_GT(ratio, 0.95) << cells;
    before = ratio;
  }
  EXPECT_LT(before, 1.4);  // linear tets lock
}

TEST(Corotational, answers_alike_however_it_is_turned) {
  const Mat3 turn = Eigen::AngleAxisd(1.1, Vec3(1, 2, -0.5).normalized()).matrix();
  CorotationalBody upright(coarse_block(Mat3::Identity(), {6, 6, 3}), {.ball = kBall}),
      turned(coarse_block(turn, {6, 6, 3}), {.ball = kBall});
  const Vec3 a = press_and_drag(upright, Mat3::Identity(), 1e-3),
             b = press_and_drag(turned, turn, 1e-3);
  EXPECT_LT((turn * a - b).norm(), 1e-3 * a.norm()) << a.transpose();
  EXPECT_GT(a.x(), 0.1 * -a.z());
  EXPECT_LT(a.x(), 0.5 * -a.z());
  upright.start();
  EXPECT_TRUE(upright.force(Vec3(0.03, 0.03, 0.1)).isZero());
}

TEST(Explicit, comes_to_rest_near_the_simulator_as_its_mesh_gets_finer) {
  const double simulated_N = simulated_press_N();
  double before = 10;
  for (const int cells : {6, 12, 20}) {
    ExplicitBody body(coarse_block(Mat3::Identity(), {cells, cells, cells / 2}), {.ball = kBall});
    const double ratio = rest_pressed(body, 400).z() / simulated_N;
    EXPECT_LT(ratio, before) << cells;
    EXPECT_GT(ratio, 0.95) << cells;
    before = ratio;
  }
  EXPECT_LT(before, 1.4);  // linear tets lock
}

TEST(Explicit, six_times_the_stable_step_is_not_stable) {
  ExplicitSettings settings{.ball = kBall};
  ExplicitBody stable(coarse_block(Mat3::Identity(), {6, 6, 3}), settings);
  EXPECT_LT(rest_pressed(stable, 50).norm(), 10);
  // The longest stable step is at least this, and steps are about six times it.
  const double stable_s = settings.tick_s / stable.steps() / settings.step_of_stable;
  settings.step_of_stable = 6;
  settings.tick_s = 100 * stable_s;
  ExplicitBody unstable(coarse_block(Mat3::Identity(), {6, 6, 3}), settings);
  rest_pressed(unstable, 50);
  EXPECT_FALSE(unstable.displacement().norm() < 1);
}

#if PALPATE_BULLET
TEST(Bullet, comes_to_rest_near_the_simulator_as_its_mesh_gets_finer) {
  const double simulated_N = simulated_press_N();
  double before = 10;
  for (const int cells : {4, 8}) {
    BulletBody body(coarse_block(Mat3::Identity(), {cells, cells, cells / 2}),
                    {.ball = kBall, .density_kg_m3 = 6000});
    const double ratio = rest_pressed(body, 200).z() / simulated_N;
    EXPECT_LT(ratio, before) << cells;
    EXPECT_GT(ratio, 0.8) << cells;
    before = ratio;
  }
  EXPECT_LT(before, 2.5);
}
#endif

// Where PALPATE_PACKAGES names a folder with npm's @mujoco/mujoco.
TEST(Mujoco, comes_to_rest_near_the_simulator_as_its_mesh_gets_finer) {
  const char* folder = std::getenv("PALPATE_PACKAGES");
  if (folder == nullptr) GTEST_SKIP() << "PALPATE_PACKAGES is not set";
  ASSERT_TRUE(has_mujoco(folder)) << folder;
  const double simulated_N = simulated_press_N();
  double before = 10;
  for (const int cells : {6, 12}) {
    MujocoBody body(coarse_block(Mat3::Identity(), {cells, cells, cells / 2}), {.ball = kBall},
                    folder);
    const double ratio = rest_pressed(body, 60).z() / simulated_N;
    EXPECT_LT(ratio, before) << cells;
    EXPECT_GT(ratio, 0.8) << cells;
    before = ratio;
  }
  EXPECT_LT(before, 2.5);
}

TEST(Mujoco, is_left_out_without_its_package) {
  EXPECT_FALSE(has_mujoco({}));
  EXPECT_FALSE(has_mujoco(testing::TempDir()));
  EXPECT_TRUE(prepare_mujoco({}).empty());
}

}  // namespace
}  // namespace palpate::tools
