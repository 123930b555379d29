#include "tools/realtime/play.hpp"

#include <fmt/core.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "libfit/core/error.hpp"
#include "libfit/core/statistics.hpp"
#include "tools/realtime/two_thread_tip.hpp"

namespace palpate::tools {
namespace {

using runtime::AssetView;

constexpr int kPriority = 80;  // above drivers' threads, below the kernel's watchdogs

double now_ns() noexcept {
  timespec time;
  clock_gettime(CLOCK_MONOTONIC, &time);
  return 1e9 * static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec);
}

void sleep_until_ns(double when) noexcept {
  timespec time;
  time.tv_sec = static_cast<time_t>(when / 1e9);
  time.tv_nsec = static_cast<long>(when - 1e9 * static_cast<double>(time.tv_sec));
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, nullptr) == EINTR) {
  }
}

// Real-time priority and locked memory for as long as this lives; what was refused is in the
// report.
class RealtimePrivileges {
 public:
  explicit RealtimePrivileges(RealtimeReport& report) : report_(report) {
    pthread_getschedparam(pthread_self(), &policy_, &parameters_);
    sched_param wanted{};
    wanted.sched_priority = kPriority;
    const int refused = pthread_setschedparam(pthread_self(), SCHED_FIFO, &wanted);
    report.is_fifo = refused == 0;
    if (refused != 0)
      report.remark =
          fmt::format("SCHED_FIFO was refused ({}): the force thread ran like any other",
                      std::strerror(refused));
    report.is_locked = mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
    if (!report.is_locked)
      report.remark += fmt::format("{}memory could not be locked ({})",
                                   report.remark.empty() ? "" : "; ", std::strerror(errno));
  }
  ~RealtimePrivileges() {
    if (report_.is_fifo) pthread_setschedparam(pthread_self(), policy_, &parameters_);
    if (report_.is_locked) munlockall();
  }
  RealtimePrivileges(const RealtimePrivileges&) = delete;
  RealtimePrivileges& operator=(const RealtimePrivileges&) = delete;

 private:
  RealtimeReport& report_;
  int policy_ = 0;
  sched_param parameters_{};
};

}  // namespace

RealtimeReport play_in_real_time(const AssetView& asset, const Points& tip_m, double rate_Hz,
                                 std::vector<PlayedTick>& played, bool (*is_interrupted)()) {
  if (!(rate_Hz >= 1 && rate_Hz <= 1e5))
    throw Error("--realtime", "the rate must be between 1 and 100000 Hz", "1000 is usual.");
  RealtimeReport report;
  const std::size_t ticks = tip_m.rows();
  played.assign(ticks, {});
  report.jitter_ns.assign(ticks, 0);
  report.tick_ns.assign(ticks, 0);
  TwoThreadTip tip(asset, 1 / rate_Hz, report);  // its thread begins before the priority is raised
  {
    const RealtimePrivileges privileges(report);
    const double period_ns = 1e9 / rate_Hz, start_ns = now_ns() + 10e6;
    for (std::size_t i = 0; i < ticks && !is_interrupted(); ++i) {
      const double due_ns = start_ns + i * period_ns;
      sleep_until_ns(due_ns);
      const double began_ns = now_ns();
      const double x[3] = {tip_m(i, 0), tip_m(i, 1), tip_m(i, 2)};
      tip.tick(static_cast<int>(i), x, played[i]);
      const double ended_ns = now_ns();
      report.jitter_ns[i] = began_ns - due_ns;
      report.tick_ns[i] = ended_ns - began_ns;
      report.missed += ended_ns > due_ns + period_ns;
      report.ticks = i + 1;
    }
  }
  for (auto* column : {&report.jitter_ns, &report.tick_ns}) column->resize(report.ticks);
  played.resize(report.ticks);
  return report;
}

std::string histogram(const std::string& what, std::vector<double> ns) {
  if (ns.empty()) return what + ": no ticks";
  const auto at = [&](double share) { return 1e-3 * quantile(ns, share); };
  std::string text = fmt::format("{}: median {:.1f} us, p99 {:.1f}, p99.9 {:.1f}, worst {:.1f}",
                                 what, at(0.5), at(0.99), at(0.999), at(1));
  std::array<std::size_t, 64> count{};
  for (double each : ns) ++count[std::bit_width(static_cast<std::uint64_t>(std::max(0.0, each)))];
  for (std::size_t bin = 1; bin < count.size(); ++bin) {
    if (count[bin] == 0) continue;
    const auto bar = static_cast<std::size_t>(
        50.0 * static_cast<double>(count[bin]) / static_cast<double>(ns.size()) + 0.999);
    text += fmt::format("\n  below {:9.2f} us {:8} {}",
                        1e-3 * static_cast<double>(std::uint64_t{1} << bin), count[bin],
                        std::string(bar, '#'));
  }
  return text;
}

}  // namespace palpate::tools
