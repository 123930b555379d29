// Coarse bodies answer as the simulator does where their meshes get finer.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "libfem/mesh/topology.hpp"
#include "tests/libfem/solve/block.hpp"
#include "tools/workshop/rivals/bullet_body.hpp"
#include "tools/workshop/rivals/corotational.hpp"
#include "tools/workshop/rivals/mujoco.hpp"
#include "tools/workshop/rivals/rivals.hpp"
#include "tools/workshop/rivals/total_lagrangian.hpp"

namespace palpate::tools {
namespace {

CoarseBody coarse_block(int cells) {
  const TetMesh mesh = fem::structured_block({0.06, 0.06, 0.03}, {cells, cells, cells / 2});
  CoarseBody body{mesh.nodes, mesh.tets, {}, {}, {}, {}};
  for (const auto& node : mesh.nodes.rowwise()) body.is_held.push_back(node[2] < 1e-6);
  body.young_Pa = Eigen::VectorXd::Constant(mesh.tets.rows(), fem::kYoung_Pa);
  body.poisson = Eigen::VectorXd::Constant(mesh.tets.rows(), fem::kPoisson);
  const TetMesh fine = fem::structured_block({0.06, 0.06, 0.03}, {30, 30, 2});
  body.carried =
      carried_points(mesh.nodes, mesh.tets, {fine.nodes, fem::boundary_triangles(fine.tets)},
                     fem::block_top().transpose(), 0.018);
  return body;
}

constexpr BallContact kBall{
    .radius_m = 8e-3, .friction = 0.3, .penalty_Pa_m = 20e3 * fem::kYoung_Pa};

// The simulator's force [N] 2 mm deep.
double simulated_press_N() {
  fem::SimulationSetup setup = fem::block_setup(0.3);
  fem::Experiments experiments = fem::press_only(1);
  experiments.depth_m = 2e-3;
  setup.options.growth = 0.6;
  setup.options.coarse_ratio = 1.6;
  const fem::PointRows rows =
      fem::Simulator(setup).press_and_drag(fem::block_top(), -Vec3::UnitZ(), experiments);
  EXPECT_EQ(rows.status[0], RowStatus::good);
  return rows.force.row(0).z();
}

// Presses by 2 mm in steps of 40 um and stays for some ticks, on blocks of more and more cells: its
// force comes down towards the simulator's, to a multiple of it at last.
template <class Make>
void expect_nearer(const Make& make, int ticks, const std::vector<int>& cells, double least,
                   double most) {
  const double simulated_N = simulated_press_N();
  double before = 10;
  for (const int each : cells) {
    auto body = make(coarse_block(each));
    double force_N = 0;
    for (int k = 0; k <= 50 + ticks; ++k) {
      const double height_m = kBall.radius_m - 4e-5 * std::min(k, 50);
      force_N = body.force(fem::block_top() + height_m * Vec3::UnitZ()).z();
    }
    EXPECT_LT(force_N / simulated_N, before) << each;
    EXPECT_GT(force_N / simulated_N, least) << each;
    before = force_N / simulated_N;
  }
  EXPECT_LT(before, most);  // linear tets lock
}

TEST(Corotational, comes_down_to_the_simulator_as_its_mesh_gets_finer) {
  expect_nearer([](const CoarseBody& b) { return CorotationalBody(b, {.ball = kBall}); }, 50,
                {6, 12, 20}, 0.95, 1.4);
}

TEST(Explicit, comes_to_rest_near_the_simulator_as_its_mesh_gets_finer) {
  expect_nearer([](const CoarseBody& b) { return ExplicitBody(b, {.ball = kBall}); }, 450,
                {6, 12, 20}, 0.95, 1.4);
}

#if PALPATE_BULLET
TEST(Bullet, comes_to_rest_near_the_simulator_as_its_mesh_gets_finer) {
  expect_nearer(
      [](const CoarseBody& b) { return BulletBody(b, {.ball = kBall, .density_kg_m3 = 6000}); },
      250, {4, 8}, 0.8, 2.5);
}
#endif

// Where PALPATE_PACKAGES names a folder with npm's @mujoco/mujoco.
TEST(Mujoco, comes_to_rest_near_the_simulator_as_its_mesh_gets_finer) {
  const char* folder = std::getenv("PALPATE_PACKAGES");
  if (folder == nullptr) GTEST_SKIP() << "PALPATE_PACKAGES is not set";
  ASSERT_TRUE(has_mujoco(folder)) << folder;
  expect_nearer([&](const CoarseBody& b) { return MujocoBody(b, {.ball = kBall}, folder); }, 110,
                {6, 12}, 0.8, 2.5);
}

}  // namespace
}  // namespace palpate::tools
