// Benchmarks measure what they say; a real-time replay brings what a plain one does.

#include <gtest/gtest.h>

#include "tests/libfit/runtime/models.hpp"
#include "tools/bench/bodies.hpp"
#include "tools/bench/finger_proxy.hpp"
#include "tools/bench/tick_flops.hpp"
#include "tools/bench/tick_work.hpp"
#include "tools/realtime/play.hpp"

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

TEST(realtime, a_replay_on_the_clock_brings_the_forces_of_a_plain_one_from_the_touch_on) {
  const test::Loaded sphere =
      test::load(test::sphere_model(0.03, 20, test::uniform(400, 300, 0.3)));
  Points path(1200, 3);
  for (int i = 0; i < path.rows(); ++i) {
    const double t = i * 2e-3, r = 0.0295 + 0.0015 * std::cos(9 * t);
    path.row(i) << 0.8 * r * std::sin(t), 0.6 * r * std::sin(t), r * std::cos(t);
  }
  std::vector<PlayedTick> played;
  const RealtimeReport report =
      play_in_real_time(sphere.asset, path, 2000, played, [] { return false; });
  ASSERT_EQ(played.size(), 1200U);
  EXPECT_EQ(report.ticks, 1200U);
  EXPECT_GE(report.touches, 1U);
  EXPECT_EQ(report.is_fifo && report.is_locked, report.remark.empty());
  EXPECT_GT(*std::min_element(report.jitter_ns.begin(), report.jitter_ns.end()), 0);
  runtime::Contact contact;
  runtime::Output out;
  // A busy machine may let the thread that searches sleep through the beginning of a touch, or all
  // of one: forces count from where each touch was found.
  int same = 0, found = 0, touching = 0;
  bool is_found = false;
  for (int i = 0; i < path.rows(); ++i) {
    const Vec3 x = path.row(i);
    runtime::touch(sphere.asset, contact, x.data(), out);
    const Vec3 plain = Vec3::Map(out.force_on_tool_N),
               live = Vec3::Map(played[static_cast<std::size_t>(i)].out.force_on_tool_N);
    if (plain.norm() == 0) {
      is_found = false;
      continue;
    }
    ++touching;
    is_found = is_found || live.norm() > 0;
    found += is_found;
    same += is_found && (live - plain).norm() <= 0.02 * plain.norm() + 1e-3;
  }
  EXPECT_GT(touching, 300);
  EXPECT_GT(found, 0);
  EXPECT_GE(same, 0.9 * found);
}

TEST(realtime, impossible_rates_are_refused) {
  const test::Loaded plate = test::load(test::plate_model(0.1, 4, test::uniform(400, 300, 0.3)));
  std::vector<PlayedTick> played;
  for (double rate : {0.0, -5.0, 1e9, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_ANY_THROW(
        play_in_real_time(plate.asset, Points::Zero(3, 3), rate, played, [] { return false; }));
}

}  // namespace
}  // namespace palpate::tools
