#include "tools/realtime/play.hpp"

#include <fmt/core.h>
#include <pthread.h>
#include <sched.h>
#include <semaphore.h>
#include <sys/mman.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstring>
#include <system_error>
#include <thread>

#include "libfit/core/error.hpp"
#include "libfit/core/statistics.hpp"

namespace palpate::tools {
namespace {

// The paper's arrangement: a force thread that only evaluates its contact, and a search thread that
// finds first touches for it.

// A queue of one writer and one reader that neither waits nor allocates. Capacity: a power of two.
template <class T, std::size_t kCapacity>
class Queue {
 public:
  bool push(const T& value) noexcept {
    const std::size_t at = written_.load(std::memory_order_relaxed);
    if (at - read_.load(std::memory_order_acquire) == kCapacity) return false;
    slot_[at % kCapacity] = value;
    written_.store(at + 1, std::memory_order_release);
    return true;
  }
  bool pop(T& value) noexcept {
    const std::size_t at = read_.load(std::memory_order_relaxed);
    if (at == written_.load(std::memory_order_acquire)) return false;
    value = slot_[at % kCapacity];
    read_.store(at + 1, std::memory_order_release);
    return true;
  }

 private:
  std::array<T, kCapacity> slot_{};
  std::atomic<std::size_t> written_{0}, read_{0};
};

// A stay in the air is an epoch: what belongs to an earlier one is out of date.
struct Motion {
  std::uint64_t epoch;
  int tick;
  runtime::Vec3d from, to;
};
struct Touch {
  std::uint64_t epoch;
  int tick;
  runtime::Contact contact;
};

// Sweeps motions that the force thread hands over and hands back the first touch of each epoch.
class SearchThread {
 public:
  explicit SearchThread(const runtime::AssetView& asset) : asset_(asset) {
    sem_init(&work_, 0, 0);
    try {
      thread_ = std::thread([this] { run(); });
    } catch (const std::system_error& e) {
      sem_destroy(&work_);
      throw Error("replay --realtime", std::string("no search thread can be made: ") + e.what(),
                  "Raise the limit of processes.");
    }
  }
  ~SearchThread() {
    stops_.store(true);
    sem_post(&work_);
    thread_.join();
    sem_destroy(&work_);
  }
  SearchThread(const SearchThread&) = delete;
  SearchThread& operator=(const SearchThread&) = delete;

  /// False when the search has fallen a queue behind: the force thread searches this motion itself.
  bool hand_over(const Motion& motion) noexcept {
    const bool is_taken = motions_.push(motion);
    if (is_taken) sem_post(&work_);
    return is_taken;
  }
  bool take(Touch& touch) noexcept { return touches_.pop(touch); }

 private:
  void run() {
    std::uint64_t done_epoch = 0;  // a touch was found in it
    while (true) {
      while (sem_wait(&work_) != 0) {
      }
      if (stops_.load()) return;
      Motion motion;
      if (!motions_.pop(motion) || motion.epoch == done_epoch) continue;
      runtime::Contact contact;
      runtime::find_contact(asset_, contact, motion.from, motion.to);
      if (contact.triangle < 0) continue;
      done_epoch = motion.epoch;
      touches_.push({motion.epoch, motion.tick, contact});
    }
  }

  const runtime::AssetView& asset_;
  Queue<Motion, 1024> motions_;
  Queue<Touch, 1024> touches_;
  sem_t work_;
  std::atomic<bool> stops_{false};
  std::thread thread_;
};

// The force thread's side of a contact: touch() while in contact, motions handed over in the air.
class TwoThreadTip {
 public:
  TwoThreadTip(const runtime::AssetView& asset, double tick_s, RealtimeReport& report)
      : asset_(asset), tick_s_(tick_s), report_(report), search_(asset) {}

  void tick(int at, const double tip_m[3], PlayedTick& played) noexcept {
    const runtime::Vec3d x =
        runtime::make_vec3<double>(tip_m) - runtime::make_vec3<double>(asset_.origin_m);
    if (contact_.triangle < 0) take_touch(at);
    if (contact_.triangle < 0 && hands_over(at, x)) {
      report_air(played);
      return;
    }
    const bool was_in_contact = contact_.triangle >= 0;
    played.status = runtime::touch(asset_, contact_, tip_m, played.out, nullptr, tick_s_);
    if (was_in_contact && contact_.triangle < 0) ++epoch_;
  }

 private:
  void take_touch(int at) noexcept {
    Touch touch;
    while (search_.take(touch)) {
      if (touch.epoch != epoch_) continue;
      contact_.triangle = touch.contact.triangle;
      for (int k = 0; k < 3; ++k) contact_.weight[k] = touch.contact.weight[k];
      contact_.arm = touch.contact.arm;
      ++report_.touches;
      report_.worst_touch_delay = std::max(report_.worst_touch_delay, at - touch.tick);
    }
  }
  // In the air with nothing unusual about the motion. The rest is left to touch().
  bool hands_over(int at, const runtime::Vec3d& x) noexcept {
    const runtime::Vec3d before = contact_.has_tip ? runtime::make_vec3<double>(contact_.tip_m) : x,
                         step = x - before;
    const bool is_usual = dot(step, step) <= asset_.max_step_m * asset_.max_step_m;
    if (!is_usual || !search_.hand_over({epoch_, at, before, x})) {
      ++epoch_;
      return false;
    }
    contact_.has_tip = true;
    contact_.asset_checksum = asset_.checksum;
    runtime::put(x, contact_.tip_m);
    return true;
  }
  void report_air(PlayedTick& played) const noexcept {
    played = PlayedTick();
    runtime::put_sums(contact_.ledger, played.out);
  }

  const runtime::AssetView& asset_;
  double tick_s_;
  RealtimeReport& report_;
  runtime::Contact contact_;
  std::uint64_t epoch_ = 1;
  SearchThread search_;
};

using runtime::AssetView;

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
    wanted.sched_priority = 80;  // above drivers' threads, below the kernel's watchdogs
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
