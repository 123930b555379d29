// A contact that tires (contact/ageing.hpp), by itself and beside all other memories.

#include <gtest/gtest.h>

#include <cmath>

#include "tests/libfit/runtime/models.hpp"

namespace palpate::test {
namespace {

TEST(ageing, a_held_tool_loses_its_share_with_time_and_a_new_contact_has_rested) {
  Model model = plate_model(0.08, 16, uniform(400, 300, 0.3));
  make_rings(
      model, 0.5, 0, [](const Vec3&) { return 1.0; }, nullptr);
  model.curves.ageing = {0.4, 2.0, {}};
  const Loaded loaded = load(model);
  Contact contact;
  Output out;
  const auto tick = [&](double z_m) {
    const Vec3 tip(0.001, 0.002, z_m);
    EXPECT_EQ(touch(loaded.asset, contact, tip.data(), out, nullptr, 0.01), Status::ok);
    return -out.force_on_tool_N[2];
  };
  tick(0.001);
  const double first_N = tick(-0.002);
  double before_J = out.stored_J;
  for (int k = 1; k <= 400; ++k) {
    const double held_N = tick(-0.002);
    EXPECT_NEAR(held_N / first_N, (1 - 0.4 * (1 - std::exp(-0.01 * k / 2))) / 1.0, 2e-3) << k;
    EXPECT_LE(out.stored_J, before_J);
    before_J = out.stored_J;
  }
  tick(0.001);
  EXPECT_NEAR(tick(-0.002) / first_N, 1, 1e-3);
}

}  // namespace
}  // namespace palpate::test
