#pragma once

#include <array>
#include <ctime>
#include <string_view>

namespace palpate::fem {

/// What an equilibrium spends its time on.
enum class Phase { other, stiffness, force, contact, model, analysis, factor, apply, multiply };
inline constexpr int kPhases = 9;
inline constexpr std::array<std::string_view, kPhases> kPhaseNames{
    "other", "stiffness", "force", "contact", "model", "analysis", "factor", "apply", "multiply"};

/// CPU time of the calling thread by phase [s]; a phase within another counts for itself alone.
/// For benchmarks: nothing that is computed depends on it. One thread at a time.
struct Profile {
  std::array<double, kPhases> seconds{};
  std::array<int, kPhases> calls{};

  static double now_s() {
    timespec time;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  }

 private:
  friend class PhaseTimer;
  Phase current_ = Phase::other;
  double since_s_ = now_s();

  Phase enter(Phase phase) {
    const double now = now_s();
    seconds[static_cast<std::size_t>(current_)] += now - since_s_;
    since_s_ = now;
    const Phase before = current_;
    current_ = phase;
    return before;
  }
};

/// Counts the time of a scope for a phase; does nothing without a profile.
class PhaseTimer {
 public:
  PhaseTimer(Profile* profile, Phase phase) : profile_(profile) {
    if (!profile_) return;
    before_ = profile_->enter(phase);
    ++profile_->calls[static_cast<std::size_t>(phase)];
  }
  ~PhaseTimer() {
    if (profile_) profile_->enter(before_);
  }
  PhaseTimer(const PhaseTimer&) = delete;
  PhaseTimer& operator=(const PhaseTimer&) = delete;

 private:
  Profile* profile_;
  Phase before_ = Phase::other;
};

}  // namespace palpate::fem
