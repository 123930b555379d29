#include "libfem/calibrate/homogeneous_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/libfem/materials/examples.hpp"

namespace palpate::fem {
namespace {

constexpr double kIncompressible = 0.49999999;

HomogeneousTest test_of(std::string_view name, std::vector<double> stretch) {
  HomogeneousTest test;
  for (const HomogeneousTestRow& row : kHomogeneousTests)
    if (row.name == name) test.row = &row;
  test.stretch = Eigen::Map<Eigen::VectorXd>(stretch.data(), std::ssize(stretch));
  test.stress = Eigen::VectorXd::Zero(test.stretch.size());
  return test;
}

double stress(const MaterialParameters& material, std::string_view name, double stretch) {
  const Eigen::VectorXd found = stresses(make_material(material, "test"), test_of(name, {stretch}));
  return found.size() == 1 ? found[0] : NAN;
}

// Treloar, The Physics of Rubber Elasticity (1975), 5.
TEST(HomogeneousTests, of_mooney_rivlin_are_the_closed_forms_of_an_incompressible_body) {
  const double a = 2e3, b = 700;
  const MaterialParameters material{"mooney-rivlin", {a, b, kIncompressible}};
  for (const double l : {0.4, 0.8, 0.999, 1.0, 1.001, 1.5, 3.0, 7.0}) {
    SCOPED_TRACE(l);
    const auto expect = [&](std::string_view name, double closed_form) {
      EXPECT_NEAR(stress(material, name, l), closed_form, 2e-5 * std::abs(closed_form) + 1e-6);
    };
    expect("uniaxial", 2 * (l - std::pow(l, -2)) * (a + b / l));
    expect("equibiaxial", 2 * (l - std::pow(l, -5)) * (a + b * l * l));
    expect("planar", 2 * (l - std::pow(l, -3)) * (a + b));
    expect("simple-shear", 2 * l * (a + b));
  }
}

TEST(HomogeneousTests, true_stress_is_nominal_stress_times_the_stretch_of_an_incompressible_body) {
  const MaterialParameters material{"yeoh", {1e3, 200, 30, kIncompressible}};
  HomogeneousTest test = test_of("uniaxial", {0.5, 2});
  const Eigen::VectorXd nominal = stresses(material, std::vector{test});
  test.is_true = true;
  EXPECT_LT((stresses(material, std::vector{test}) - nominal.cwiseProduct(test.stretch)).norm(),
            1e-5 * nominal.norm());
}

// Every law, compressible as its example is: E, E/(1 - nu), E/(1 - nu^2) and mu.
TEST(HomogeneousTests, of_every_law_begin_with_the_moduli_of_small_strain) {
  for (const examples::Example& example : examples::all()) {
    if (example.is_kinked_at_rest) continue;
    SCOPED_TRACE(example.name);
    const MaterialParameters& material = example.parameters;
    const Material made = make_material(material, "test");
    const SmallStrain small = made.law->small_strain(made.constants);
    const double E = small.young_Pa(), nu = small.poisson(), e = 1e-5;
    const auto slope = [&](std::string_view name) {
      return (stress(material, name, 1 + e) - stress(material, name, 1 - e)) / (2 * e);
    };
    EXPECT_NEAR(slope("uniaxial"), E, 1e-4 * E);
    EXPECT_NEAR(slope("equibiaxial"), E / (1 - nu), 1e-4 * E);
    EXPECT_NEAR(slope("planar"), E / (1 - nu * nu), 1e-4 * E);
    EXPECT_NEAR(stress(material, "simple-shear", e) / e, small.mu_Pa, 1e-4 * small.mu_Pa);
  }
}

TEST(HomogeneousTests, say_nothing_where_a_state_has_no_solution) {
  HomogeneousTest test = test_of("uniaxial", {1.5, -1});
  EXPECT_EQ(stresses({"neo-hookean", {1e3, 0.45}}, std::vector{test}).size(), 0);
}

}  // namespace
}  // namespace palpate::fem
