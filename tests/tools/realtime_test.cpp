// A real-time replay brings what a plain one does.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/libfit/runtime/models.hpp"
#include "tools/realtime/play.hpp"

namespace palpate::tools {
namespace {

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
