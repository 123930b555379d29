#include "tools/realtime/clock.hpp"

#include <fmt/core.h>
#include <pthread.h>
#include <sys/mman.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "libfit/core/error.hpp"
#include "libfit/core/statistics.hpp"

namespace palpate::tools {
namespace {

double now_ns() {
  timespec time;
  clock_gettime(CLOCK_MONOTONIC, &time);
  return 1e9 * double(time.tv_sec) + double(time.tv_nsec);
}

void sleep_until_ns(double when) {
  timespec time;
  time.tv_sec = static_cast<time_t>(when / 1e9);
  time.tv_nsec = static_cast<long>(when - 1e9 * double(time.tv_sec));
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, nullptr) == EINTR) {
  }
}

// "median 2.1 us, p99 8.0, worst 31" and bars by powers of two.
std::string histogram(const std::string& name, const std::vector<double>& ns) {
  if (ns.empty()) return name + ": no ticks";
  const auto at = [&](double share) { return 1e-3 * quantile(ns, share); };
  std::string text = fmt::format("{}: median {:.1f} us, p99 {:.1f}, p99.9 {:.1f}, worst {:.1f}",
                                 name, at(0.5), at(0.99), at(0.999), at(1));
  std::array<std::size_t, 64> count{};
  for (double each : ns) ++count[std::bit_width(static_cast<std::uint64_t>(std::max(0.0, each)))];
  for (std::size_t bin = 1; bin < count.size(); ++bin) {
    if (count[bin] == 0) continue;
    const auto bar =
        static_cast<std::size_t>(50.0 * double(count[bin]) / double(ns.size()) + 0.999);
    text += fmt::format("\n  below {:9.2f} us {:8} {}", 1e-3 * std::ldexp(1, int(bin)), count[bin],
                        std::string(bar, '#'));
  }
  return text;
}

}  // namespace

RealtimeClock::RealtimeClock(double rate_Hz, std::size_t ticks) : period_ns_(1e9 / rate_Hz) {
  if (!(rate_Hz >= 1 && rate_Hz <= 1e5))
    throw Error("--realtime", "the rate must be between 1 and 100000 Hz", "1000 is usual.");
  jitter_ns_.reserve(ticks);
  tick_ns_.reserve(ticks);
  pthread_getschedparam(pthread_self(), &policy_, &parameters_);
  sched_param wanted{};
  wanted.sched_priority = 80;  // above drivers' threads, below the kernel's watchdogs
  const int refused = pthread_setschedparam(pthread_self(), SCHED_FIFO, &wanted);
  is_fifo_ = refused == 0;
  if (!is_fifo_)
    remark_ = fmt::format("SCHED_FIFO was refused ({}): the thread ran like any other",
                          std::strerror(refused));
  is_locked_ = mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
  if (!is_locked_)
    remark_ += fmt::format("{}memory could not be locked ({})", remark_.empty() ? "" : "; ",
                           std::strerror(errno));
  due_ns_ = now_ns() + 10e6;
}

RealtimeClock::~RealtimeClock() {
  if (is_fifo_) pthread_setschedparam(pthread_self(), policy_, &parameters_);
  if (is_locked_) munlockall();
}

void RealtimeClock::wait() {
  sleep_until_ns(due_ns_);
  began_ns_ = now_ns();
  jitter_ns_.push_back(began_ns_ - due_ns_);
}

void RealtimeClock::done() {
  const double ended_ns = now_ns();
  tick_ns_.push_back(ended_ns - began_ns_);
  due_ns_ += period_ns_;
  missed_ += ended_ns > due_ns_;
}

std::vector<std::string> RealtimeClock::report() const {
  return {fmt::format("{} ticks at {:.0f} Hz, {} deadlines missed; {}", ticks(), 1e9 / period_ns_,
                      missed_, remark_.empty() ? "SCHED_FIFO, memory locked" : remark_),
          histogram("jitter of the clock", jitter_ns_), histogram("time of a tick", tick_ns_)};
}

}  // namespace palpate::tools
