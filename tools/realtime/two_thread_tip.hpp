#pragma once

// The paper's arrangement: a force thread that only evaluates its contact, and a search thread that
// finds first touches for it.

#include <semaphore.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <system_error>
#include <thread>

#include "libfit/core/error.hpp"
#include "tools/realtime/play.hpp"

namespace palpate::tools {

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
struct Way {
  std::uint64_t epoch;
  int tick;
  runtime::Vec3d from, to;
};
struct Touch {
  std::uint64_t epoch;
  int tick;
  runtime::Contact contact;
};

// Sweeps ways that the force thread hands over and hands back the first touch of each epoch.
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

  /// False when the search has fallen a queue behind: the force thread searches this way itself.
  bool hand_over(const Way& way) noexcept {
    const bool is_taken = ways_.push(way);
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
      Way way;
      if (!ways_.pop(way) || way.epoch == done_epoch) continue;
      runtime::Contact contact;
      runtime::find_contact(asset_, contact, way.from, way.to);
      if (contact.triangle < 0) continue;
      done_epoch = way.epoch;
      touches_.push({way.epoch, way.tick, contact});
    }
  }

  const runtime::AssetView& asset_;
  Queue<Way, 1024> ways_;
  Queue<Touch, 1024> touches_;
  sem_t work_;
  std::atomic<bool> stops_{false};
  std::thread thread_;
};

// The force thread's side of a contact: touch() while in contact, ways handed over in the air.
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
  // In the air with nothing unusual about the way. The rest is left to touch().
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

}  // namespace palpate::tools
