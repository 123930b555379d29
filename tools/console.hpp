#pragma once

#include <fmt/core.h>

#include <memory>
#include <stdexcept>
#include <string>

#include "libfit/core/progress.hpp"

namespace palpate::tools {

/// Thrown when the user interrupted and what is done has been saved; main turns it into status 130.
class Interrupted : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// First SIGINT or SIGTERM asks long work to stop and keep what is done; a second one kills.
void catch_interrupts();
bool is_interrupted();

/// Plain lines to stderr, so that stdout stays free for --json.
template <class... T>
void say(fmt::format_string<T...> format, T&&... arguments) {
  fmt::print(stderr, "{}\n", fmt::format(format, std::forward<T>(arguments)...));
}

/// Progress of long work: a bar with an estimate on a terminal, a plain line at most every ten
/// seconds otherwise. The estimate is items left x mean time of the items done in this run.
class ConsoleProgress {
 public:
  explicit ConsoleProgress(std::string what);
  ~ConsoleProgress();
  ConsoleProgress(const ConsoleProgress&) = delete;
  ConsoleProgress& operator=(const ConsoleProgress&) = delete;

  /// Callbacks to hand to a library; valid while this object lives.
  Progress progress();

 private:
  void show(std::size_t done, std::size_t total, const std::string& latest);

  struct State;
  std::unique_ptr<State> state_;
};

/// Wall seconds since some fixed point, for reports.
double wall_seconds();

/// "3.2 s", "4 min 10 s".
std::string in_words(double seconds);

/// Threads to use: `jobs` where positive, else all cores.
int job_count(int jobs);

}  // namespace palpate::tools
