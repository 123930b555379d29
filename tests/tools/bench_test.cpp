// Benchmarks measure what they say.

#include <gtest/gtest.h>

#include "tests/libfit/runtime/models.hpp"
#include "tests/support/bodies.hpp"
#include "tools/workshop/bench/tick_flops.hpp"
#include "tools/workshop/bench/tick_work.hpp"
#include "tools/workshop/rivals/finger_proxy.hpp"

namespace palpate::tools {
namespace {

TEST(tick_work, each_kind_brings_what_it_is_named_for) {
  const BenchAsset body = make_bench_asset(bench_cylinder(75, 32));
  for (const TickKind& kind : kTicksOfKind) {
    runtime::Contact contact;
    runtime::Output out;
    const Vec3 outside = kind.tip(0) * 1.2;
    runtime::touch(body.asset, contact, outside.data(), out);
    int count[3] = {0, 0, 0};
    for (long i = 0; i < 2000; ++i) {
      const Vec3 x = kind.tip(i);
      ASSERT_EQ(runtime::touch(body.asset, contact, x.data(), out), runtime::Status::ok);
      ++count[static_cast<int>(out.state)];
    }
    const int expected = kind.name == "slip" ? 2 : kind.name == "touch" ? 0 : 1;
    EXPECT_GT(count[expected], 1500) << kind.name;
    if (contact.triangle >= 0) {
      const std::size_t lines = lines_of_a_tick(body.asset, contact).size();
      EXPECT_GT(lines, 15U);
      EXPECT_LT(lines, 60U);
    }
  }
}

TEST(tick_work, arithmetic_of_a_press_is_that_of_its_curves_and_its_frame) {
  const BenchAsset body = make_bench_asset(bench_cylinder(75, 32));
  runtime::Contact contact;
  runtime::Output out;
  for (long i = 0; i < 1300; ++i) {
    const Vec3 x = kTicksOfKind[1].tip(i) * (i == 0 ? 1.2 : 1);
    runtime::touch(body.asset, contact, x.data(), out);
  }
  ASSERT_EQ(out.state, runtime::ContactState::stick);
  const Vec3 x = kTicksOfKind[1].tip(1300);
  // Three cubics (t, Horner), two integrals (t, shares, Horner, the area below), deflection from
  // where the anchor rests, response and its energy.
  const long curve = 1 + 3 * 2, area = 1 + 1 + 3 * 3 + 2, frame = 27, force = 9 + 1;
  EXPECT_EQ(flops_of_a_tick(body.asset, contact, x.data()), 3 * curve + 2 * area + frame + force);
}

TEST(finger_proxy, presses_like_a_spring_and_drags_along_its_cone) {
  const test::Loaded plate = test::load(test::plate_model(0.1, 20, test::uniform(400, 300, 0.3)));
  FingerProxy proxy(plate.asset, 400, 0.3);
  runtime::Vec3d f{0, 0, 0};
  for (int i = 0; i <= 40; ++i) {
    const double x[3] = {0.001, 0.0013, 0.001 - 1e-4 * i};
    f = proxy.tick(x);
  }
  EXPECT_NEAR(f.z, -1.2, 1e-9);
  for (int i = 0; i <= 200; ++i) {
    const double x[3] = {0.001 + 1e-4 * i, 0.0013, -0.003};
    f = proxy.tick(x);
  }
  EXPECT_NEAR(f.x, 0.3 * 1.2, 1e-9);
}

}  // namespace
}  // namespace palpate::tools
