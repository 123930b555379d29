#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "libfem/materials/materials.hpp"
#include "tests/support/error_of.hpp"

namespace palpate::fem {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::string message_of(const MaterialParameters& parameters) {
  return testing_support::error_of([&] { make_material(parameters, "scene.toml [material]"); });
}

TEST(MaterialRefusals, missing_and_infinite_values_are_refused) {
  EXPECT_EQ(message_of({"neo-hookean", {}}),
            "scene.toml [material]: law neo-hookean takes 2 values, not 0\n"
            "  Give young, poisson (may be left out).");
  EXPECT_EQ(message_of({"neo-hookean", {1e4, 0.4, 1}}),
            "scene.toml [material]: law neo-hookean takes 2 values, not 3\n"
            "  Give young, poisson (may be left out).");
  EXPECT_EQ(message_of({"neo-hookean", {kNaN, 0.4}}),
            "scene.toml [material]: young is not a finite number\n"
            "  Give Young's modulus at small strain.");
  EXPECT_NE(message_of({"neo-hookean", {std::numeric_limits<double>::infinity(), 0.4}}),
            "accepted");
}

TEST(MaterialRefusals, values_left_out_have_their_fallbacks) {
  const Material given = make_material({"yeoh", {1e3, 0, 0, 0.45, kNaN}}, "test");
  EXPECT_EQ(make_material({"yeoh", {1e3}}, "test").constants, given.constants);
  const Material by_bulk = make_material({"yeoh", {1e3, 0, 0, 0.45, 7e5}}, "test");
  EXPECT_NEAR(by_bulk.law->small_strain(by_bulk.constants).bulk_Pa(), 7e5, 1e-6);
}

/// Refused with this beginning of the fact.
void expect_refused(const std::string& law, const std::vector<double>& values,
                    const std::string& fact) {
  EXPECT_EQ(message_of({law, values}).substr(0, 23 + fact.size()),
            "scene.toml [material]: " + fact);
}

TEST(MaterialRefusals, materials_that_are_not_stable_are_refused) {
  expect_refused("neo-hookean", {0, 0.45}, "young must be positive, not 0 Pa");
  expect_refused("neo-hookean", {1e4, -1}, "poisson must lie above -1 and below 0.5, not -1");
  EXPECT_EQ(message_of({"neo-hookean", {1e4, 0.499}}), "accepted");
  expect_refused("mooney-rivlin", {-1, 5}, "c10 must not be negative, not -1 Pa");
  expect_refused("mooney-rivlin", {5, -1}, "c01 must not be negative, not -1 Pa");
  expect_refused("mooney-rivlin", {0, 0}, "c10 and c01 must not both be zero");
  EXPECT_EQ(message_of({"mooney-rivlin", {0, 5}}), "accepted");
  expect_refused("yeoh", {0}, "c10 must be positive, not 0 Pa");
  expect_refused("yeoh", {1, 0, -1}, "c30 must not be negative");
  expect_refused("yeoh", {1, -1, 0.33},
                 "c20 must be above -sqrt(3 c10 c30) = -0.994987 Pa, not -1 Pa");
  EXPECT_EQ(message_of({"yeoh", {1, -1, 0.34}}), "accepted");
  expect_refused("ogden", {1, -2}, "mu1 times alpha1 must be positive, not -2 Pa");
  expect_refused("ogden", {1, 2, 3}, "alpha2 is missing beside mu2");
  expect_refused("ogden", {1, 2, kNaN, 2}, "mu2 is missing beside alpha2");
  expect_refused("ogden", {1, 60}, "alpha1 must lie between -50 and 50, not 60");
  expect_refused("ogden", {1, 0}, "mu1 times alpha1 must be positive, not 0 Pa");
  expect_refused("fung", {1, 0}, "b must be positive, not 0");
  expect_refused("fung", {-1, 2}, "shear must be positive, not -1 Pa");
  expect_refused("holzapfel-gasser-ogden", {1, 1, 1, 0, 0, 0}, "fibre must have a direction");
  expect_refused("holzapfel-gasser-ogden", {1, -1, 1, 1, 0, 0}, "k1 must not be negative");
  expect_refused("holzapfel-gasser-ogden", {1, 1, 1, 1, 0, 0, 0.34},
                 "dispersion must lie between 0 and 1/3");
  expect_refused("yeoh", {1, 0, 0, 0.5}, "poisson must lie above -1 and below 0.5, not 0.5");
  expect_refused("yeoh", {1, 0, 0, 0.45, -3}, "bulk must be positive, not -3 Pa");
}

TEST(MaterialRefusals, fibres_count_by_direction_not_by_length) {
  const Material a = make_material({"holzapfel-gasser-ogden", {1e3, 1e3, 1, 3, 0, 4}}, "test");
  const Material b = make_material({"holzapfel-gasser-ogden", {1e3, 1e3, 1, 0.6, 0, 0.8}}, "test");
  for (int i = 0; i < kMaxConstants; ++i) EXPECT_NEAR(a.constants[i], b.constants[i], 1e-13);
}

}  // namespace
}  // namespace palpate::fem
