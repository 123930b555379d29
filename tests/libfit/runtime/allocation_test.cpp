// No allocation in a million ticks, and in ten million in a program of its own (engine_long): every
// way to the heap is counted.

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "tests/libfit/runtime/models.hpp"

namespace {
std::atomic<long> allocations{0};
}

// The sanitizers bring their own heap, which must not be replaced.
#if defined(__SANITIZE_ADDRESS__)
#define PALPATE_COUNTS_MALLOC 0
#else
#define PALPATE_COUNTS_MALLOC 1
extern "C" void* __libc_malloc(std::size_t size);
extern "C" void* __libc_calloc(std::size_t count, std::size_t size);
extern "C" void* __libc_realloc(void* old, std::size_t size);
extern "C" void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
extern "C" void* calloc(std::size_t count, std::size_t size) {
  ++allocations;
  return __libc_calloc(count, size);
}
extern "C" void* realloc(void* old, std::size_t size) {
  ++allocations;
  return __libc_realloc(old, size);
}
#endif

namespace palpate::test {
namespace {

#ifndef PALPATE_TICKS
#define PALPATE_TICKS 1000000
#endif

TEST(allocation, no_tick_of_a_tip_or_a_ball_takes_heap) {
  if (!PALPATE_COUNTS_MALLOC) GTEST_SKIP() << "a sanitizer owns the heap";
  const Loaded sphere = load(sphere_model(0.03, 20, uniform(400, 300, 0.3)));
  const long start = allocations;
  const std::unique_ptr<int> probe = std::make_unique<int>(1);
  ASSERT_EQ(allocations, start + 1) << "the counter does not count";
  Contact contact, ball_contact;
  Output out, ball_out;
  double tangent[9];
  long touching = 0, statuses = 0;
  const long before = allocations;
  for (int tick = 0; tick < PALPATE_TICKS; ++tick) {
    const double t = tick * 1e-3, radius = 0.029 + 0.002 * std::sin(t);
    const double angle = 0.3 * t, polar = 1.5 + std::sin(0.11 * t);
    double tip[3] = {radius * std::sin(polar) * std::cos(angle),
                     radius * std::sin(polar) * std::sin(angle), radius * std::cos(polar)};
    if (tick % 9973 == 0) tip[1] = std::numeric_limits<double>::quiet_NaN();
    statuses += touch(sphere.asset, contact, tip, out) != Status::ok;
    if (tick % 4 == 0) touch_ball(sphere.asset, ball_contact, tip, 0.003, ball_out, tangent);
    touching += out.state != ContactState::air;
  }
  EXPECT_EQ(allocations - before, 0);
  EXPECT_GT(touching, 100000);
  EXPECT_EQ(statuses, (PALPATE_TICKS + 9972) / 9973);
}

}  // namespace
}  // namespace palpate::test
