#pragma once

#include <fmt/core.h>

#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "libfit/core/progress.hpp"

namespace palpate::tools {

/// Thrown when the user interrupted and what is done has been saved; main turns it into status 130.
class Interrupted : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// First SIGINT or SIGTERM asks long work to stop and keep what is done; a second one kills.
/// SIGABRT is METIS's in the threads where it runs.
void catch_interrupts();
bool is_interrupted();

/// Runs work that knows no Progress (meshers) on a thread of its own and returns or throws what it
/// does. Once interrupted it is not waited for: throws Interrupted(`lost`), and the program must
/// end through run_program, which then leaves without destructors, and child processes with it.
/// work: holds by value whatever it uses.
void run_abandonably(std::function<void()> work, const std::string& lost);
bool has_abandoned_work();

/// Amount of output: errors and failed items alone; all; all with the time since the start.
enum class Loudness { quiet, normal, verbose };
void set_loudness(Loudness loudness);
bool is_verbose();

/// Kind of a line on stderr. Warnings and failed items are remembered for --json; a failed item is
/// shown whatever the loudness, as an error is.
enum class Tone { note, warning, failed };
void say_line(Tone tone, const std::string& line);
const std::vector<std::string>& said(Tone tone);

/// Writes to stderr. What cannot be written there is lost: nothing ends for want of its messages,
/// as it would with fmt::print, which throws.
template <class... T>
void to_stderr(fmt::format_string<T...> format, T&&... arguments) {
  const std::string text = fmt::format(format, std::forward<T>(arguments)...);
  std::fwrite(text.data(), 1, text.size(), stderr);
}

/// Plain lines to stderr, so that stdout stays free for the answer.
template <class... T>
void say(fmt::format_string<T...> format, T&&... arguments) {
  say_line(Tone::note, fmt::format(format, std::forward<T>(arguments)...));
}
template <class... T>
void warn(fmt::format_string<T...> format, T&&... arguments) {
  say_line(Tone::warning, fmt::format(format, std::forward<T>(arguments)...));
}
/// One of the things asked for that did not work out: exit status 3.
template <class... T>
void say_failed(fmt::format_string<T...> format, T&&... arguments) {
  say_line(Tone::failed, fmt::format(format, std::forward<T>(arguments)...));
}

/// Warns of columns of a table that say nothing to its reader; of none says nothing.
void warn_of_unused(const std::string& file, const std::vector<std::string>& columns);

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

/// While it lives, notes and progress go to a file instead of stderr, where they are with --verbose
/// alone; warnings go to both, on stderr each once. At most one lives.
class RunLog {
 public:
  RunLog();
  ~RunLog();
  RunLog(const RunLog&) = delete;
  RunLog& operator=(const RunLog&) = delete;

  /// Appends to a file, after `title`, what was said since construction and what follows. Throws
  /// Error where it cannot.
  void open(const std::filesystem::path& file, const std::string& title);
  /// A line for stderr, too.
  void say_summary(const std::string& line);
};

/// Wall seconds since some fixed point, for reports.
double wall_seconds();

/// "3.2 s", "4 min 10 s".
std::string in_words(double seconds);

/// Threads to use: `jobs` where positive, all cores where it is 0. Throws Error below 0 and above
/// 1024.
int job_count(int jobs);

}  // namespace palpate::tools
