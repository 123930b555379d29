#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>

#include "record.hpp"
#include "tests/libfem/solve/cylinder.hpp"

// A press with contact on one mesh. References: axisymmetric Q2/P-1 solutions, good
// to 0.3 %, of a frictionless ball pressed 1 to 10 mm into a cylinder.

namespace palpate::fem {
namespace {

using Forces = std::array<double, 10>;
constexpr Forces kReference045{0.056213, 0.162001, 0.300782, 0.465666, 0.652051,
                               0.855974, 1.074112, 1.303358, 1.540461, 1.782624};
constexpr Forces kReference049{0.058636, 0.168528, 0.312130, 0.482380, 0.674115,
                               0.883201, 1.106157, 1.339524, 1.579860, 1.824296};

class ElementPress : public testing::TestWithParam<std::pair<double, Forces>> {};

// On the default mesh; the penalty is stiff so that its bias stays out of it.
TEST_P(ElementPress, one_mesh_is_near_the_truth) {
  const auto& [poisson, reference_N] = GetParam();
  SimulationSetup setup = ball_on_cylinder(poisson);
  setup.options.coarse_ratio = 0;
  setup.options.contact.stiffness = 2000;
  Experiments experiments;
  experiments.depth_m = 0.01;
  experiments.press_steps = 10;
  const double start = validation::cpu_seconds();
  const PointRows result =
      Simulator(setup).press_and_drag(Vec3::Zero(), -Vec3::UnitZ(), experiments);
  const double cost = validation::cpu_seconds() - start;
  for (std::size_t k = 0; k < reference_N.size(); ++k) {
    ASSERT_EQ(result.status[k], RowStatus::good) << k + 1 << " mm";
    const double force_N = -result.force.row(k).z(), error = force_N / reference_N[k] - 1;
    char id[64];
    std::snprintf(id, sizeof id, "AXI/nu%.2f/d%zu", poisson, k + 1);
    validation::record_case(id, reference_N[k], force_N, "N", error, cost);
    if (k >= 2) {  // where the contact is more than an element wide
      EXPECT_LT(std::abs(error), 0.02) << k + 1 << " mm";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Poisson, ElementPress,
                         testing::Values(std::pair{0.45, kReference045},
                                         std::pair{0.49, kReference049}),
                         [](const auto& row) { return row.param.first < 0.47 ? "p45" : "p49"; });

}  // namespace
}  // namespace palpate::fem
