#include <gtest/gtest.h>

#include <limits>

#include "libfem/materials/materials.hpp"
#include "libfit/core/error.hpp"

namespace palpate::fem {
namespace {

std::string message_of(const MaterialParameters& parameters) {
  try {
    make_material(parameters, "scene.toml [material]");
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

TEST(MaterialRefusals, an_unknown_law_is_refused_with_the_known_ones) {
  EXPECT_EQ(message_of({"neohookean", {1e4, 0.45}}),
            "scene.toml [material]: unknown material law \"neohookean\"\n"
            "  Use one of: neo-hookean.");
}

TEST(MaterialRefusals, a_young_modulus_that_is_not_positive_is_refused) {
  EXPECT_EQ(message_of({"neo-hookean", {-1e4, 0.45}}),
            "scene.toml [material]: young must be positive, not -10000.000000 Pa\n"
            "  Correct the material; law neo-hookean takes young, poisson.");
  EXPECT_NE(message_of({"neo-hookean", {0, 0.45}}), "accepted");
}

TEST(MaterialRefusals, a_poisson_ratio_without_a_finite_bulk_modulus_is_refused) {
  EXPECT_EQ(message_of({"neo-hookean", {1e4, 0.5}}),
            "scene.toml [material]: poisson must lie above -1 and below 0.5, not 0.500000\n"
            "  Correct the material; law neo-hookean takes young, poisson.");
  EXPECT_NE(message_of({"neo-hookean", {1e4, -1}}), "accepted");
  EXPECT_EQ(message_of({"neo-hookean", {1e4, 0.499}}), "accepted");
}

TEST(MaterialRefusals, missing_and_infinite_values_are_refused) {
  EXPECT_EQ(message_of({"neo-hookean", {1e4}}),
            "scene.toml [material]: law neo-hookean takes 2 values, not 1\n"
            "  Give young, poisson.");
  EXPECT_EQ(message_of({"neo-hookean", {std::numeric_limits<double>::quiet_NaN(), 0.4}}),
            "scene.toml [material]: young is not a finite number\n"
            "  Give Young's modulus at small strain.");
  EXPECT_NE(message_of({"neo-hookean", {std::numeric_limits<double>::infinity(), 0.4}}), "accepted");
}

}  // namespace
}  // namespace palpate::fem
