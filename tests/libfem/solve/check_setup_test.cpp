#include <gtest/gtest.h>

#include "block.hpp"
#include "tests/support/error_of.hpp"

namespace palpate::fem {
namespace {

std::string message_of(const SimulationSetup& setup) {
  return testing_support::error_of([&] { check_setup(setup); });
}

TEST(CheckSetup, refuses_a_body_that_nothing_holds) {
  SimulationSetup setup = block_setup(0.3);
  setup.is_held.assign(setup.is_held.size(), 0);
  EXPECT_EQ(message_of(setup),
            "[body] fixed: no node is held, so a press would push the body away\n"
            "  Give `fixed` a region that holds part of the body, such as the face it lies on.");
  setup.is_held[0] = setup.is_held[1] = 1;
  EXPECT_EQ(message_of(setup),
            "[body] fixed: fewer than three nodes are held, so a press would turn the body about "
            "them\n"
            "  Give `fixed` a region that holds part of the body, such as the face it lies on.");
  EXPECT_THROW(Simulator{setup}, Error);
}

TEST(CheckSetup, says_which_material_is_wrong) {
  SimulationSetup setup = block_setup(0.3);
  setup.materials.push_back({"neo-hookean", {1e4, 0.5}});
  EXPECT_EQ(message_of(setup),
            "[[inclusion]] 1: poisson must lie above -1 and below 0.5, not 0.5\n"
            "  Correct the material; law neo-hookean takes young, poisson (may be left out).");
}

}  // namespace
}  // namespace palpate::fem
