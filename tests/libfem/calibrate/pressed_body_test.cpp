#include "libfem/calibrate/pressed_body.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "libfem/solve/experiments/simulate.hpp"
#include "libfit/core/samples.hpp"
#include "tests/libfem/calibrate/region_holds.hpp"
#include "tests/libfem/solve/block.hpp"

namespace palpate::fem {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// A press of 6 mm by a ball of 8 mm on the block, of `material`.
SimulationSetup setup_of(const MaterialParameters& material) {
  SimulationSetup setup = block_setup(0);
  setup.materials = {material};
  return setup;
}

Samples pressed(const SimulationSetup& setup, int steps) {
  Experiments press = press_only(steps);
  press.depth_m = 0.006;
  return simulate(Simulator(setup), experiments_at(one_point()), press, {.jobs = 1});
}

const MaterialParameters kYeoh{"yeoh", {2e3, 1500, 0, 0.45, kNone}};
const MaterialParameters kMooneyRivlin{"mooney-rivlin", {1500, 500, 0.45, kNone}};

TEST(PressedBody, needs_one_simulation_of_a_press_for_a_law_of_one_modulus) {
  const MaterialParameters truth{"neo-hookean", {7.3e3, 0.45}};
  const Samples samples = pressed(setup_of(truth), 5);
  const MaterialParameters start{"neo-hookean", {100e3, 0.45}};
  PressedBody body(setup_of(start), samples, "test", 1);
  const Identification found = identify(body, start, {.free = {0}});
  EXPECT_EQ(body.simulated, 1u);
  EXPECT_TRUE(found.is_converged);
  EXPECT_NEAR(found.material.values[0], 7.3e3, 1e-3 * 7.3e3);
}

TEST(PressedBody, simulates_a_press_with_the_ball_that_made_it) {
  const MaterialParameters truth{"neo-hookean", {7.3e3, 0.45}}, start{"neo-hookean", {20e3, 0.45}};
  SimulationSetup narrow = setup_of(truth);
  narrow.probe = sphere_spec(0.005, narrow.probe.friction);
  Samples samples = joined(pressed(setup_of(truth), 4), pressed(narrow, 4));
  ASSERT_EQ(samples.points(), 2);
  samples.probe_number.assign(static_cast<std::size_t>(samples.rows()), 0);
  samples.other_probes = {narrow.probe};
  for (std::size_t row = 4; row < 8; ++row) {
    samples.kind[row] = ExperimentKind::other;
    samples.probe_number[row] = 1;
  }
  PressedBody body(setup_of(start), samples, "test", 1);
  EXPECT_EQ(body.observed().value.size(), 8);
  const Identification found = identify(body, start, {.free = {0}});
  EXPECT_NEAR(found.material.values[0], 7.3e3, 1e-3 * 7.3e3);
  EXPECT_EQ(body.simulated, 2u) << "one of each ball";
}

// The rows need not lie at the depths that are simulated.
TEST(PressedBody, answers_at_depths_between_the_simulated_ones) {
  const MaterialParameters material{"neo-hookean", {10e3, 0.45}};
  const Samples samples = pressed(setup_of(material), 15);  // simulated again in 10 steps
  PressedBody body(setup_of(material), samples, "test", 1);
  const Eigen::VectorXd force = body.forces({material}, PressMesh::scene, {}).front();
  ASSERT_EQ(force.size(), 15);
  const double largest = samples.force.row(14).norm();
  for (Eigen::Index i = 0; i < 15; ++i)
    EXPECT_NEAR(force[i], samples.force.row(i).norm(), 2e-3 * largest) << i;
  EXPECT_NEAR(force[0], samples.force.row(0).norm(), 0.01 * force[0]) << "of light rows likewise";
}

TEST(PressedBody, finds_two_parameters_in_a_few_simulations) {
  const Samples samples = pressed(setup_of(kYeoh), 5);
  const MaterialParameters start{"yeoh", {1e3, 100, 0, 0.45, kNone}};
  PressedBody body(setup_of(start), samples, "test", 1);
  const Identification found = identify(body, start, {.free = {0, 1}});
  EXPECT_TRUE(found.is_converged);
  EXPECT_NEAR(found.material.values[0], 2e3, 0.01 * 2e3);
  EXPECT_NEAR(found.material.values[1], 1500, 0.02 * 1500);
  EXPECT_LE(body.simulated, 60u);  // 40 by g++ 12, 48 by g++ 14, in other last digits
  RecordProperty("simulated", static_cast<int>(body.simulated));

  // What is known is not simulated again, and the result is the same.
  PressedBody again(setup_of(start), samples, "test", 1);
  again.known = body.known;
  const Identification same = identify(again, start, {.free = {0, 1}});
  for (const std::size_t i : {0, 1}) EXPECT_EQ(same.material.values[i], found.material.values[i]);
  EXPECT_EQ(again.simulated, 0u);
}

/// The responses of a two-parameter law from presses at Chebyshev nodes of the angle between its
/// moduli: by the exact scaling they are functions of that angle, times the length.
class Table {
 public:
  Table(PressedBody& body, const MaterialParameters& truth) : truth_(truth) {
    for (int i = 0; i < kNodes; ++i) {
      angle_.push_back(kLargest / 2 * (1 - std::cos(std::numbers::pi * (i + 0.5) / kNodes)));
      node_.push_back(body.forces({at(angle_.back())}, PressMesh::coarse, {}).front());
    }
  }
  MaterialParameters at(double angle) const {
    MaterialParameters material = truth_;
    material.values[0] = 1e3 * std::cos(angle);
    material.values[1] = 1e3 * std::sin(angle);
    return material;
  }
  Eigen::VectorXd operator()(const MaterialParameters& material) const {
    const double angle = std::atan2(material.values[1], material.values[0]);
    if (angle < 0 || angle > kLargest) return {};
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(node_.front().size());
    for (int i = 0; i < kNodes; ++i) {
      double weight = 1;
      for (int j = 0; j < kNodes; ++j)
        if (j != i) weight *= (angle - angle_[j]) / (angle_[i] - angle_[j]);
      sum += weight * node_[i];
    }
    return sum * std::hypot(material.values[0], material.values[1]) / 1e3;
  }
  static constexpr int kNodes = 11;
  static constexpr double kLargest = 1.5;

 private:
  MaterialParameters truth_;
  std::vector<double> angle_;
  std::vector<Eigen::VectorXd> node_;
};

TEST(PressedBody, holds_the_truth_in_90_of_100_regions_from_presses_with_2_percent_noise) {
  for (const MaterialParameters& truth : {kYeoh, kMooneyRivlin}) {
    const Samples samples = pressed(setup_of(truth), 8);
    PressedBody body(setup_of(truth), samples, "test", 1);
    const Table table(body, truth);
    const Eigen::VectorXd exact = body.forces({truth}, PressMesh::coarse, {}).front();
    ASSERT_LT((table(truth) - exact).norm(), 5e-4 * exact.norm()) << "the table is the simulator";
    int held = 0, told_apart = 0;
    for (unsigned seed = 1; seed <= 100; ++seed) {
      std::mt19937 random(seed);
      std::normal_distribution<double> normal(0, 0.02 * exact.maxCoeff());
      Observations observed = body.observed();
      for (Eigen::Index i = 0; i < exact.size(); ++i) observed.value[i] = exact[i] + normal(random);
      observed.deviation.setConstant(normal.stddev());
      MaterialParameters start = truth;
      start.values[0] = start.values[1] = 1e3;
      const Identification found = identify(start, observed,
                                            [&](const std::vector<MaterialParameters>& materials) {
                                              std::vector<Eigen::VectorXd> out;
                                              for (const MaterialParameters& material : materials)
                                                out.push_back(table(material));
                                              return out;
                                            },
                                            {.free = {0, 1}});
      held += region_holds(found, Eigen::Vector2d(truth.values[0], truth.values[1]));
      told_apart += found.are_told_apart;
    }
    RecordProperty(truth.law + "_held", held);
    RecordProperty(truth.law + "_told_apart", told_apart);
    std::printf("%s: %d held, %d told apart\n", truth.law.c_str(), held, told_apart);
    EXPECT_GE(held, 90) << truth.law;
  }
}

}  // namespace
}  // namespace palpate::fem
