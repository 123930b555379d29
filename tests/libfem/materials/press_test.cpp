#include <gtest/gtest.h>

#include "tests/libfem/materials/examples.hpp"
#include "tests/libfem/solve/cylinder.hpp"
#include "tests/validation/record.hpp"

namespace palpate::fem {
namespace {

// A ball of 10 mm pressed into a cylinder of 10 kPa by the whole solver, with every isotropic law.

constexpr double kYoung_Pa = 10e3, kPoisson = 0.45, kShear_Pa = kYoung_Pa / (2 * (1 + kPoisson));

double press_N(const MaterialParameters& material, double depth_m, int steps) {
  SimulationSetup setup = ball_on_cylinder(kPoisson);
  setup.materials = {material};
  setup.options.coarse_ratio = 0;
  Experiments experiments;
  experiments.depth_m = depth_m;
  experiments.press_steps = steps;
  experiments.drag_depths_m = {};
  const PointRows point =
      Simulator(setup).press_and_drag(Vec3::Zero(), Vec3(0, 0, -1), experiments);
  EXPECT_EQ(point.rows.back().status, RowStatus::good) << material.law;
  return point.rows.back().force.norm();
}

// 0.2 mm are 2 % of the ball's radius: strains are small but for second-order terms.
TEST(LawsUnderAProbe, alike_at_small_strain_press_alike_at_small_depth) {
  const double reference_N = press_N({"neo-hookean", {kYoung_Pa, kPoisson}}, 2e-4, 1);
  const std::vector<MaterialParameters> materials{
      {"neo-hookean-simo", {kYoung_Pa, kPoisson}},
      {"neo-hookean-isochoric", {kYoung_Pa, kPoisson}},
      {"neo-hookean-isochoric-log", {kYoung_Pa, kPoisson}},
      {"neo-hookean-isochoric-simo", {kYoung_Pa, kPoisson}},
      {"stable-neo-hookean", {kYoung_Pa, kPoisson}},
      {"mooney-rivlin", {kShear_Pa / 4, kShear_Pa / 4, kPoisson}},
      {"yeoh", {kShear_Pa / 2, kShear_Pa / 20, kShear_Pa / 20, kPoisson}},
      {"ogden", {kShear_Pa / 2, 4}},
      {"fung", {kShear_Pa, 1.5, kPoisson}},
      {"veronda-westmann", {kShear_Pa / 1.2, 1.2, kPoisson}},
  };
  for (const MaterialParameters& material : materials) {
    const double start_s = validation::cpu_seconds();
    const double force_N = press_N(material, 2e-4, 1);
    EXPECT_NEAR(force_N, reference_N, 0.02 * reference_N) << material.law;
    validation::record_case("MAT/press/" + material.law, reference_N, force_N, "N",
                            force_N / reference_N - 1, validation::cpu_seconds() - start_s);
  }
}

TEST(LawsUnderAProbe, ogden_with_exponent_2_presses_as_neo_hookean_does) {
  const double neo_hookean_N = press_N({"neo-hookean-isochoric", {kYoung_Pa, kPoisson}}, 8e-3, 4);
  const double ogden_N = press_N({"ogden", {kShear_Pa, 2}}, 8e-3, 4);
  EXPECT_NEAR(ogden_N, neo_hookean_N, 1e-6 * neo_hookean_N);
}

TEST(LawsUnderAProbe, fibres_along_the_surface_resist_more_than_fibres_along_the_press) {
  const auto with_fibres = [](Vec3 a) {
    return MaterialParameters{"holzapfel-gasser-ogden",
                              {kShear_Pa, kShear_Pa, 1, a[0], a[1], a[2], 0, kPoisson}};
  };
  const double along_N = press_N(with_fibres(Vec3::UnitX()), 4e-3, 2);
  const double across_N = press_N(with_fibres(Vec3::UnitZ()), 4e-3, 2);
  const double matrix_N = press_N({"neo-hookean-isochoric", {kYoung_Pa, kPoisson}}, 4e-3, 2);
  EXPECT_GT(along_N, 1.05 * across_N);
  EXPECT_NEAR(across_N, matrix_N, 0.01 * matrix_N);  // shortened fibres are slack
}

}  // namespace
}  // namespace palpate::fem
