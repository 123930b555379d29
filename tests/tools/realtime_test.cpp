// The clock of `replay --realtime`; asset_commands_test.cpp replays by it.

#include <gtest/gtest.h>
#include <sched.h>

#include <algorithm>
#include <limits>

#include "tools/realtime/clock.hpp"

namespace palpate::tools {
namespace {

TEST(realtime, no_tick_begins_before_it_is_due_and_the_thread_is_given_back) {
  const int before = sched_getscheduler(0);
  {
    RealtimeClock clock(2000, 300);
    EXPECT_DOUBLE_EQ(clock.period_s(), 5e-4);
    for (int i = 0; i < 300; ++i) {
      clock.wait();
      clock.done();
    }
    EXPECT_EQ(clock.ticks(), 300);
    EXPECT_GT(*std::ranges::min_element(clock.jitter_ns()), 0);
    EXPECT_EQ(clock.report().size(), 3u);
  }
  EXPECT_EQ(sched_getscheduler(0), before);
}

TEST(realtime, impossible_rates_are_refused) {
  for (double rate : {0.0, -5.0, 1e9, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_ANY_THROW(RealtimeClock(rate, 3));
}

}  // namespace
}  // namespace palpate::tools
