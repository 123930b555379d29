// Cases that break solvers: each row is right, or refused with its reason. `Right` is agreement
// with the same case on a mesh half as coarse again, within the row's own error bound and 3 % of
// the force.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "libfem/mesh/topology.hpp"
#include "libfit/core/error.hpp"
#include "tests/libfem/solve/block.hpp"
#include "tests/validation/record.hpp"

namespace palpate::fem {
namespace {

using validation::cpu_seconds;
using validation::record_case;
using validation::record_curve;

constexpr double kAgreement = 0.03;  // of the force

struct HardCase {
  std::string name;
  SimulationSetup setup;
  Vec3 position, normal;
  Experiments experiments;
};

Experiments press(double depth_m, int steps) {
  Experiments experiments;
  experiments.depth_m = depth_m;
  experiments.press_steps = steps;
  return experiments;
}

/// A press and, at its depth, a drag as far along the first tangent.
Experiments press_and_drag(double depth_m, int steps) {
  Experiments experiments = press(depth_m, steps);
  experiments.drag_depths_m = {depth_m};
  experiments.drag_distance_m = depth_m;
  experiments.drag_directions = 1;
  experiments.drag_steps = 4;
  return experiments;
}

SimulationSetup layer(double thickness_m, double poisson, double radius_m) {
  SimulationSetup setup = block_setup(0.3);
  setup.volume = structured_block(Vec3(0.06, 0.06, thickness_m), {6, 6, 1});
  setup.is_held = held_below(setup.volume.nodes, 1e-6);
  setup.surface = {setup.volume.nodes, boundary_triangles(setup.volume.tets)};
  setup.materials = {{"neo-hookean", {kYoung_Pa, poisson}}};
  setup.probe = sphere_spec(radius_m, 0.3);
  setup.options = SolverOptions();
  return setup;
}

// Runs the case as shipped and finer, prints both, and holds every good row against the finer one.
// Returns how many rows are good.
int expect_right_or_refused(const HardCase& hard) {
  const double start = cpu_seconds();
  const PointRows shipped =
      Simulator(hard.setup).press_and_drag(hard.position, hard.normal, hard.experiments);
  const double cost = cpu_seconds() - start;
  std::printf("%s: %d nodes (twin %d), %d Newton, %d model, %d factorizations, %.1f s CPU\n",
              hard.name.c_str(), shipped.cost.nodes, shipped.cost.coarse_nodes,
              shipped.cost.solver.newton, shipped.cost.solver.model,
              shipped.cost.solver.factorizations, cost);
  std::fflush(stdout);
  SimulationSetup finer = hard.setup;
  finer.options.element_size /= 1.6;
  finer.options.growth /= 1.6;
  finer.options.coarse_ratio = 0;
  const PointRows reference =
      Simulator(finer).press_and_drag(hard.position, hard.normal, hard.experiments);
  int good = 0;
  const Vec3 drag_way = drag_tangents(hard.normal, 1)[0];
  for (Eigen::Index i = 0; i < shipped.rows(); ++i) {
    const std::string where = hard.name + " row " + std::to_string(i);
    std::printf(
        "%-34s status %d step check %d, %.6f N (error bound %.6f), finer %.6f N status %d\n",
        where.c_str(), static_cast<int>(shipped.status[i]), static_cast<int>(shipped.step_check[i]),
        shipped.force.row(i).norm(), shipped.force_error[i], reference.force.row(i).norm(),
        static_cast<int>(reference.status[i]));
    if (shipped.status[i] != RowStatus::good) {
      EXPECT_TRUE(std::isnan(shipped.force_error[i])) << where << ": a refused row claims an error";
      continue;
    }
    ++good;
    EXPECT_GT(shipped.force.row(i).dot(hard.normal), 0) << where;
    EXPECT_TRUE(shipped.force_error[i] >= 0) << where << ": no error estimate";
    if (reference.status[i] != RowStatus::good) continue;
    const bool is_drag = shipped.kind[i] == ExperimentKind::drag;
    const auto along = [&](const Vec3& v) { return v.dot(is_drag ? drag_way : hard.normal); };
    record_curve(hard.name, is_drag ? "drag" : "press", 1e3 * along(shipped.deflection.row(i)),
                 along(shipped.force.row(i)), shipped.force_error[i],
                 along(reference.force.row(i)));
    const double difference = (shipped.force.row(i) - reference.force.row(i)).norm(),
                 size = reference.force.row(i).norm();
    EXPECT_LT(difference, shipped.force_error[i] + kAgreement * size) << where;
    if (i + 1 == shipped.rows())
      record_case("hard/" + hard.name, size, shipped.force.row(i).norm(), "N",
                  shipped.force.row(i).norm() / size - 1, cost);
  }
  return good;
}

TEST(HardCases, a_thin_layer_pressed_to_six_tenths_of_its_thickness) {
  const HardCase hard{"thin layer 60 %", layer(0.01, kPoisson, 0.008), Vec3(0.031, 0.0283, 0.01),
                      -Vec3::UnitZ(), press_and_drag(0.006, 6)};
  EXPECT_EQ(expect_right_or_refused(hard), 10);
}

TEST(HardCases, poisson_0_4999) {
  const HardCase hard{"nu 0.4999", layer(0.03, 0.4999, 0.008), Vec3(0.031, 0.0283, 0.03),
                      -Vec3::UnitZ(), press_and_drag(0.004, 4)};
  EXPECT_EQ(expect_right_or_refused(hard), 8);
}

// Moves every `stride`-th inner node until a tet at it is all but flat.
void make_slivers(TetMesh& mesh, const Vec3& size_m, int stride, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> draw(-1, 1);
  const auto min_volume = [&](Eigen::Index node) {  // of the tets at a node, of the body
    double least = 1;
    for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t)
      if ((mesh.tets.row(t).array() == static_cast<int>(node)).any())
        least = std::min(least, 6 * tet_volume_m3(corners_of(mesh, t)) / size_m.prod());
    return least;
  };
  int inner = 0;
  for (Eigen::Index n = 0; n < mesh.nodes.rows(); ++n) {
    const Vec3 x = mesh.nodes.row(n);
    if (((x.array() < 1e-9) || (x.array() > size_m.array() - 1e-9)).any()) continue;
    if (inner++ % stride != 0) continue;
    const Vec3 way = Vec3(draw(random), draw(random), draw(random)).normalized();
    double low = 0, high = 0.05;  // [m]; the farthest that keeps every tet just positive
    for (int i = 0; i < 40; ++i) {
      const double middle = (low + high) / 2;
      mesh.nodes.row(n) = x + middle * way;
      (min_volume(n) > 2e-6 ? low : high) = middle;
    }
    mesh.nodes.row(n) = x + low * way;
  }
}

SimulationSetup fine_block() {
  SimulationSetup setup = block_setup(0.3);
  setup.volume = structured_block(Vec3(0.06, 0.06, 0.03), {8, 8, 4});
  setup.is_held = held_below(setup.volume.nodes, 1e-6);
  setup.surface = {setup.volume.nodes, boundary_triangles(setup.volume.tets)};
  setup.options = SolverOptions();
  return setup;
}

TEST(HardCases, one_sliver_in_a_hundred_changes_little_and_a_mesh_of_slivers_is_refused) {
  constexpr unsigned kSeed = 3;
  const Vec3 size(0.06, 0.06, 0.03);
  const Experiments experiments = press_and_drag(0.004, 4);
  HardCase hard{"slivers", fine_block(), block_top(), -Vec3::UnitZ(), experiments};
  make_slivers(hard.setup.volume, size, 12, kSeed);
  int flat = 0;
  for (Eigen::Index t = 0; t < hard.setup.volume.tets.rows(); ++t)
    flat += min_dihedral_deg(corners_of(hard.setup.volume, t)) < 2;
  std::printf("seed %u: %d of %d tets below 2 degrees\n", kSeed, flat,
              static_cast<int>(hard.setup.volume.tets.rows()));
  EXPECT_GE(flat, hard.setup.volume.tets.rows() / 100);
  EXPECT_EQ(expect_right_or_refused(hard), 8);

  const PointRows even =
      Simulator(fine_block()).press_and_drag(hard.position, hard.normal, experiments);
  const PointRows with =
      Simulator(hard.setup).press_and_drag(hard.position, hard.normal, experiments);
  for (Eigen::Index i = 0; i < even.rows(); ++i) {
    const double size_N = even.force.row(i).norm();
    EXPECT_LT((with.force.row(i) - even.force.row(i)).norm(), with.force_error[i] + 0.005 * size_N)
        << "row " << i;
  }

  make_slivers(hard.setup.volume, size, 1, kSeed);
  EXPECT_THROW(Simulator(hard.setup), Error);
}

TEST(HardCases, an_inclusion_a_thousand_times_stiffer) {
  HardCase hard{"inclusion 1000:1", block_setup(0.3), block_top(), -Vec3::UnitZ(),
                press_and_drag(0.004, 4)};
  hard.setup.options = SolverOptions();
  hard.setup.materials.push_back({"neo-hookean", {1000 * kYoung_Pa, kPoisson}});
  hard.setup.region_at = [](const Vec3& x) {
    return (x - Vec3(0.031, 0.0283, 0.018)).norm() < 0.006 ? 1 : 0;
  };
  EXPECT_EQ(expect_right_or_refused(hard), 8);
}

TEST(HardCases, a_test_point_on_an_edge_and_on_a_corner) {
  for (const auto& [name, position, normal] :
       {std::tuple{"edge", Vec3(0.06, 0.031, 0.03), Vec3(-1, 0, -1)},
        std::tuple{"corner", Vec3(0.06, 0.06, 0.03), Vec3(-1, -1, -1)}}) {
    HardCase hard{name, block_setup(0), position, normal.normalized(), press(0.003, 3)};
    hard.setup.options = SolverOptions();
    expect_right_or_refused(hard);
  }
}

TEST(HardCases, a_tip_smaller_than_an_element_of_the_base_mesh) {
  HardCase hard{"tip 0.5 mm, base mesh 15 mm", block_setup(0), block_top(), -Vec3::UnitZ(),
                press(0.0005, 4)};
  hard.setup.probe = sphere_spec(0.0005);
  hard.setup.options = SolverOptions();
  EXPECT_EQ(expect_right_or_refused(hard), 4);
}

// A shallow cap of a spherical shell, standing on the rim of its underside, which turns freely.
SimulationSetup dome(double span_m, double rise_m, double thickness_m) {
  SimulationSetup setup = block_setup(0);
  const double radius = (span_m * span_m / 4 + rise_m * rise_m) / (2 * rise_m);
  setup.volume = structured_block(Vec3(2, 2, thickness_m), {12, 12, 1});
  setup.is_held.clear();
  for (Eigen::Index n = 0; n < setup.volume.nodes.rows(); ++n) {
    const double x = setup.volume.nodes(n, 0) - 1, y = setup.volume.nodes(n, 1) - 1;
    const double z = setup.volume.nodes(n, 2);
    const double scale = 0.5 * span_m * square_to_disc(x, y), r = scale * std::hypot(x, y);
    const double lift = std::sqrt(radius * radius - r * r) - radius;
    setup.volume.nodes.row(n) << scale * x, scale * y, z + lift;
    setup.is_held.push_back(std::max(std::abs(x), std::abs(y)) > 1 - 1e-9 && z < 1e-9);
  }
  setup.surface = {setup.volume.nodes, boundary_triangles(setup.volume.tets)};
  setup.probe = sphere_spec(0.005);
  setup.options = SolverOptions();
  return setup;
}

// Its force rises until the cap has almost turned over; there it snaps back, which no press can
// follow.
TEST(HardCases, a_dome_that_snaps_back_is_followed_there_and_refused) {
  const double thickness_m = 0.0015;
  HardCase hard{"dome", dome(0.08, 0.008, thickness_m), Vec3(0, 0, thickness_m), -Vec3::UnitZ(),
                press(0.016, 16)};
  hard.setup.materials = {{"neo-hookean", {100e3, 0.4}}};
  const int good = expect_right_or_refused(hard);
  EXPECT_GE(good, 10);
  EXPECT_LT(good, 16);
}

// A shallow arch on two hinges, so low that it turns over evenly (rise 1.15 thicknesses).
SimulationSetup arch() {
  constexpr double kSpan_m = 0.06, kThick_m = 0.002, kRise_m = 0.0023;
  SimulationSetup setup = block_setup(0);
  setup.volume = structured_block(Vec3(kSpan_m, 0.01, kThick_m), {24, 4, 1});
  setup.is_held.clear();
  for (Eigen::Index n = 0; n < setup.volume.nodes.rows(); ++n) {
    const double along = 2 * setup.volume.nodes(n, 0) / kSpan_m - 1, z = setup.volume.nodes(n, 2);
    setup.is_held.push_back(std::abs(along) > 1 - 1e-9 && z < 1e-9);
    setup.volume.nodes(n, 2) += kRise_m * (1 - along * along);
  }
  setup.held_at = [](const Vec3& x, bool) {  // the whole edge is a hinge, whatever its nodes
    return std::abs(2 * x.x() / kSpan_m - 1) > 1 - 1e-9 && x.z() < 1e-9;
  };
  setup.surface = {setup.volume.nodes, boundary_triangles(setup.volume.tets)};
  setup.materials = {{"neo-hookean", {100e3, 0.4}}};
  setup.options = SolverOptions();
  return setup;
}

// A press is displacement-controlled: past the limit the force falls on a branch that can be held,
// until the arch leaves the ball.
TEST(HardCases, an_arch_is_followed_past_its_limit_and_says_that_it_falls) {
  const Vec3 top(0.03, 0.005, 0.0043);
  const HardCase hard{"arch", arch(), top, -Vec3::UnitZ(), press(0.004, 16)};
  const int good = expect_right_or_refused(hard);
  const PointRows pressed =
      Simulator(hard.setup).press_and_drag(top, hard.normal, hard.experiments);
  int falling = 0;
  for (Eigen::Index i = 1; i < pressed.rows(); ++i) {
    if (pressed.status[i] != RowStatus::good) continue;
    const bool is_less = pressed.force.row(i).norm() < pressed.force.row(i - 1).norm();
    EXPECT_EQ(pressed.step_check[i] == StepCheck::falls, is_less) << "row " << i;
    falling += is_less;
  }
  EXPECT_GE(falling, 2);
  EXPECT_GE(good, 6);
}

}  // namespace
}  // namespace palpate::fem
