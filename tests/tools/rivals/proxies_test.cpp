// Proxies answer as the samples do, and the work of their tool is what it did.

#include <gtest/gtest.h>

#include <cmath>

#include "tests/tools/rivals/plate.hpp"
#include "tools/workshop/rivals/measure.hpp"

namespace palpate::tools {
namespace {

using namespace testing_rivals;

TEST_F(Proxies, press_as_the_samples_do_and_slide_on_their_cone) {
  for (const auto prepare : {prepare_proxy, prepare_proxy_on_curves}) {
    const std::vector<Rival> rivals = prepare(body_);
    ASSERT_EQ(rivals.size(), 1U);
    const Vec3 pressed = press_and_slide(rivals[0], 0), slid = press_and_slide(rivals[0], 6e-3);
    EXPECT_NEAR(pressed.z(), -2e-3 * kStiffness_N_m, 1e-6) << rivals[0].name;
    EXPECT_NEAR(pressed.head<2>().norm(), 0, 1e-9) << rivals[0].name;
    EXPECT_NEAR(slid.x() / -slid.z(), kCone, 1e-6) << rivals[0].name;
  }
}

TEST_F(Proxies, a_body_too_stiff_gets_the_modulus_of_the_presses) {
  body_.depth_m = 4e-3;
  Rival stiff = prepare_proxy(body_).front();
  stiff.force = [force = stiff.force](const Vec3& tip) -> Vec3 { return 2.5 * force(tip); };
  const Rival fitted = with_fitted_modulus(stiff, body_);
  EXPECT_NEAR(press_and_slide(fitted, 0).z(), -2e-3 * kStiffness_N_m, 1e-6) << fitted.settings;
  EXPECT_NE(fitted.settings.find("modulus x 0.4,"), std::string::npos) << fitted.settings;
}

TEST(WorkAccountOf, a_spring_that_softens_on_the_way_out_creates_energy) {
  WorkAccount account;
  for (int k = 0; k <= 20; ++k) {
    const double depth = 1e-3 * (10 - std::abs(k - 10)), stiffness = k > 10 ? 300 : 200;
    account.add({0, 0, -depth}, {0, 0, -stiffness * depth});
  }
  // In against 200 N/m, out against 300; the first step back is half of either.
  EXPECT_LT(account.work_J(), -0.4 * 0.5 * 200 * 1e-4);
  EXPECT_NEAR(account.peak_J(), 0.5 * 200 * 1e-4, 1e-12);
}

}  // namespace
}  // namespace palpate::tools
