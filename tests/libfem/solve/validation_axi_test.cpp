#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>

#include "cylinder.hpp"
#include "tests/validation/record.hpp"

namespace palpate::fem {
namespace {

constexpr double kWorst = 0.01, kReferenceError = 0.003;

struct Case {
  double poisson;
  std::array<double, 10> force_N;  // at 1, 2 .. 10 mm
};

// Axisymmetric Q2/P-1 solutions of the same equations (case AXI), good to 0.3 %.
constexpr Case kCases[] = {{0.45,
                            {0.056213, 0.162001, 0.300782, 0.465666, 0.652051, 0.855974, 1.074112,
                             1.303358, 1.540461, 1.782624}},
                           {0.49,
                            {0.058636, 0.168528, 0.312130, 0.482380, 0.674115, 0.883201, 1.106157,
                             1.339524, 1.579860, 1.824296}}};

void PrintTo(const Case& param, std::ostream* out) { *out << "poisson " << param.poisson; }

class ValidationAxi : public testing::TestWithParam<Case> {};

/// Frictionless ball of 10 mm pressed 1, 2 .. 10 mm into the top of a cylinder of 10 kPa, bottom
/// held, default options. From a place in the middle and from places off the base mesh's
/// symmetries, which a reference of radius 60 mm does not notice.
TEST_P(ValidationAxi,
       ball_on_cylinder_is_right_to_one_percent_at_every_depth_and_within_its_error) {
  const Simulator simulator(ball_on_cylinder(GetParam().poisson));
  Experiments experiments;
  experiments.depth_m = 0.01;
  experiments.press_steps = 10;
  for (const Vec3& place : {Vec3(0, 0, 0), Vec3(2.1e-3, -1.3e-3, 0), Vec3(-0.6e-3, -2.7e-3, 0)}) {
    const double start = validation::cpu_seconds();
    const PointRows result = simulator.press_and_drag(place, -Vec3::UnitZ(), experiments);
    const double cost_s = validation::cpu_seconds() - start;
    std::printf("poisson %.2f: %d nodes, coarse %d, %.2f s CPU\n", GetParam().poisson,
                result.cost.nodes, result.cost.coarse_nodes, cost_s);
    ASSERT_EQ(result.rows(), std::ssize(GetParam().force_N));
    for (Eigen::Index k = 0; k < result.rows(); ++k) {
      const double reference = GetParam().force_N[k], force = -result.force.row(k).z();
      const double error = force / reference - 1,
                   bound = result.force_error[k] / result.force.row(k).norm();
      std::printf("  %2td mm: %.6f N, error %+.2f %%, bound %.2f %%\n", k + 1, force, 100 * error,
                  100 * bound);
      EXPECT_EQ(result.status[k], RowStatus::good) << k + 1 << " mm";
      EXPECT_LT(std::abs(error), kWorst) << k + 1 << " mm";
      EXPECT_LT(std::abs(error), bound + kReferenceError) << k + 1 << " mm";
      EXPECT_LT(bound, 0.05) << k + 1 << " mm";
      if (!place.isZero()) continue;
      const std::string ratio = "AXI nu " + std::to_string(GetParam().poisson).substr(0, 4);
      validation::record_curve(ratio, "press", static_cast<double>(k + 1), force,
                               result.force_error[k], reference);
      validation::record_case("AXI/nu" + std::to_string(GetParam().poisson).substr(0, 4) + "/" +
                                  std::to_string(k + 1) + "mm",
                              reference, force, "N", error, cost_s);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Poisson, ValidationAxi, testing::ValuesIn(kCases), [](const auto& one) {
  return one.param.poisson < 0.47 ? std::string("ratio_0_45") : std::string("ratio_0_49");
});

}  // namespace
}  // namespace palpate::fem
