#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>

#include "record.hpp"
#include "tests/libfem/solve/cylinder.hpp"

// What the elements make of a press with contact. References: axisymmetric Q2/P-1 solutions, good
// to 0.3 %, of a frictionless ball pressed 1 to 10 mm into a cylinder.

namespace palpate::fem {
namespace {

using Forces = std::array<double, 10>;
constexpr Forces kReference045{0.056213, 0.162001, 0.300782, 0.465666, 0.652051,
                               0.855974, 1.074112, 1.303358, 1.540461, 1.782624};
constexpr Forces kReference049{0.058636, 0.168528, 0.312130, 0.482380, 0.674115,
                               0.883201, 1.106157, 1.339524, 1.579860, 1.824296};

/// Errors at 1 to 10 mm, on the default mesh; the penalty is stiff so that its bias stays out of
/// it.
Forces errors_of(ElementKind element, double poisson, const Forces& reference_N) {
  SimulationSetup setup = ball_on_cylinder(poisson);
  setup.options.coarse_ratio = 0;
  setup.options.contact.stiffness = 2000;
  setup.options.equilibrium.element = element;
  Experiments experiments;
  experiments.depth_m = 0.01;
  experiments.press_steps = 10;
  const double start = validation::cpu_seconds();
  const PointRows result =
      Simulator(setup).press_and_drag(Vec3::Zero(), -Vec3::UnitZ(), experiments);
  const double cost = validation::cpu_seconds() - start;
  std::string_view name;
  for (const ElementRow& row : kElements)
    if (row.kind == element) name = row.name;
  Forces errors{};
  for (std::size_t k = 0; k < errors.size(); ++k) {
    EXPECT_EQ(result.rows[k].status, RowStatus::good) << name << " " << k + 1 << " mm";
    const double force = -result.rows[k].force.z();
    errors[k] = force / reference_N[k] - 1;
    char id[64];
    std::snprintf(id, sizeof id, "AXI/nu%.2f/d%zu %s", poisson, k + 1, std::string(name).c_str());
    validation::record_case(id, reference_N[k], force, "N", errors[k], cost);
    std::printf("  %s: %+.2f %%\n", id, 100 * errors[k]);
  }
  return errors;
}

class ElementPress : public testing::TestWithParam<std::pair<double, Forces>> {};

TEST_P(ElementPress, plain_and_averaged_elements_enclose_the_truth_and_the_blend_is_nearest) {
  const auto& [poisson, reference_N] = GetParam();
  const Forces plain = errors_of(ElementKind::tet10, poisson, reference_N);
  const Forces averaged = errors_of(ElementKind::tet10_p0, poisson, reference_N);
  const Forces blend = errors_of(ElementKind::tet10_blend, poisson, reference_N);
  double sum_plain = 0, sum_blend = 0;
  // From 3 mm on, where the contact is more than an element wide.
  for (std::size_t k = 2; k < blend.size(); ++k) {
    constexpr double kDoubt = 0.012;  // of the reference, the penalty and chatter of the patch
    EXPECT_LT(averaged[k], blend[k]) << k + 1 << " mm";
    EXPECT_LT(blend[k], plain[k]) << k + 1 << " mm";
    EXPECT_LT(averaged[k], kDoubt) << k + 1 << " mm";
    EXPECT_GT(plain[k], -kDoubt) << k + 1 << " mm";
    EXPECT_LT(std::abs(blend[k]), 0.02) << k + 1 << " mm";
    sum_plain += std::abs(plain[k]);
    sum_blend += std::abs(blend[k]);
  }
  EXPECT_LT(sum_blend, 0.5 * sum_plain);
}

INSTANTIATE_TEST_SUITE_P(Poisson, ElementPress,
                         testing::Values(std::pair{0.45, kReference045},
                                         std::pair{0.49, kReference049}),
                         [](const auto& row) { return row.param.first < 0.47 ? "p45" : "p49"; });

}  // namespace
}  // namespace palpate::fem
