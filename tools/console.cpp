#include "tools/console.hpp"

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <future>
#include <mutex>
#include <thread>
#include <utility>

#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"

namespace palpate::tools {
namespace {

std::atomic<bool> interrupted{false}, abandoned{false};

void on_signal(int) { interrupted.store(true); }

constinit thread_local sighandler_t metis_abort = nullptr;  // as METIS set it in this thread
void process_handler(int) {}  // stands for what METIS would put back when it has ended

void on_abort(int signal) {
  if (metis_abort != nullptr) metis_abort(signal);
  std::signal(signal, SIG_DFL);
  std::raise(signal);  // waits until this handler returns
}

Loudness loudness = Loudness::normal;
std::array<std::vector<std::string>, 3> lines_said;

// What a RunLog takes: lines that wait for its file, then the file.
struct Log {
  bool is_there = false;
  std::string waiting;
  std::FILE* file = nullptr;

  void add(const std::string& line) {
    if (file == nullptr) {
      waiting += line + '\n';
    } else {
      std::fprintf(file, "%s\n", line.c_str());
      std::fflush(file);
    }
  }
} run_log;
std::mutex saying;  // of lines, the log's too
const double kStart_s = wall_seconds();

// Whatever the loudness, or where it is not quiet.
void show_line(const std::string& line, bool is_always) {
  if (loudness == Loudness::quiet && !is_always) return;
  if (loudness == Loudness::verbose) to_stderr("[{:8.1f} s] ", wall_seconds() - kStart_s);
  to_stderr("{}\n", line);
}

}  // namespace

void set_loudness(Loudness wanted) { loudness = wanted; }
bool is_verbose() { return loudness == Loudness::verbose; }

void say_line(Tone tone, const std::string& line) {
  const std::lock_guard<std::mutex> lock(saying);
  std::vector<std::string>& before = lines_said[static_cast<std::size_t>(tone)];
  const bool is_known =
      tone == Tone::warning && std::find(before.begin(), before.end(), line) != before.end();
  if (tone != Tone::note) before.push_back(line);
  const std::string shown = (tone == Tone::warning ? "  warning: " : "") + line;
  if (run_log.is_there) run_log.add(shown);
  if (run_log.is_there && loudness != Loudness::verbose && (tone == Tone::note || is_known)) return;
  show_line(shown, tone == Tone::failed);
}

RunLog::RunLog() { run_log.is_there = true; }

RunLog::~RunLog() {
  if (run_log.file != nullptr) std::fclose(run_log.file);
  run_log = {};
}

void RunLog::say_summary(const std::string& line) {
  const std::lock_guard<std::mutex> lock(saying);
  run_log.add(line);
  show_line(line, false);
}

void RunLog::open(const std::filesystem::path& file, const std::string& title) {
  const std::lock_guard<std::mutex> lock(saying);
  run_log.file = std::fopen(file.c_str(), "a");
  if (run_log.file == nullptr)
    throw Error(file.string(), fmt::format("cannot be written: {}", std::strerror(errno)),
                "Make its folder writable.");
  const std::string waiting = std::exchange(run_log.waiting, "");
  run_log.add(title);
  if (!waiting.empty()) run_log.add(waiting.substr(0, waiting.size() - 1));
}

const std::vector<std::string>& said(Tone tone) {
  return lines_said[static_cast<std::size_t>(tone)];
}

void warn_of_unused(const std::string& file, const std::vector<std::string>& columns) {
  if (columns.empty()) return;
  warn("{}: {} not used: {}", file, columns.size() == 1 ? "a column is" : "columns are",
       listed(columns));
}

void catch_interrupts() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = static_cast<int>(SA_RESETHAND);  // a second signal ends the program
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  action.sa_handler = on_abort;
  action.sa_flags = 0;
  sigaction(SIGABRT, &action, nullptr);
  std::signal(SIGXFSZ, SIG_IGN);  // writes beyond ulimit -f fail instead, and are named
}

bool is_interrupted() { return interrupted.load(); }

void run_abandonably(std::function<void()> work, const std::string& lost) {
  std::packaged_task<void()> task(std::move(work));
  std::future<void> done = task.get_future();
  std::thread worker(std::move(task));
  while (done.wait_for(std::chrono::milliseconds(20)) == std::future_status::timeout) {
    if (!is_interrupted()) continue;
    worker.detach();
    abandoned.store(true);
    throw Interrupted(lost);
  }
  worker.join();
  done.get();
}

bool has_abandoned_work() { return abandoned.load(); }

double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string in_words(double seconds) {
  if (seconds < 0.05) return "no time";
  if (seconds < 10) return fmt::format("{:.1f} s", seconds);
  if (seconds < 60) return fmt::format("{:.0f} s", seconds);
  const long whole = std::lround(seconds);
  if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return fmt::format("{} h {} min", whole / 3600, whole % 3600 / 60);
}

int job_count(int jobs) {
  constexpr int kMaxJobs = 1024;  // threads beyond it end for want of memory, not of work
  if (jobs < 0 || jobs > kMaxJobs)
    throw Error("--jobs", fmt::format("{} is no number of threads", jobs),
                fmt::format("Give a whole number from 1 to {}; 0 takes all cores.", kMaxJobs));
  return jobs > 0 ? jobs : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

struct ConsoleProgress::State {
  std::string what;
  std::mutex mutex;
  bool is_terminal = isatty(STDERR_FILENO) != 0;
  double started_s = wall_seconds();
  double shown_s = 0;
  bool is_first = true;
  std::size_t done_at_start = 0;
  bool has_bar = false;
};

ConsoleProgress::ConsoleProgress(std::string what) : state_(std::make_unique<State>()) {
  state_->what = std::move(what);
}

ConsoleProgress::~ConsoleProgress() {
  // Beside a log the bar was for the meantime.
  if (state_->has_bar) to_stderr("{}", run_log.is_there ? "\r\033[K" : "\n");
}

Progress ConsoleProgress::progress() {
  Progress progress;
  progress.step = [this](std::size_t done, std::size_t total, const std::string& latest) {
    show(done, total, latest);
  };
  progress.is_stopped = [] { return is_interrupted(); };
  return progress;
}

void ConsoleProgress::show(std::size_t done, std::size_t total, const std::string& latest) {
  if (loudness == Loudness::quiet) return;
  const std::lock_guard<std::mutex> lock(state_->mutex);
  const double now = wall_seconds();
  if (state_->is_first) {
    state_->done_at_start = done > 0 ? done - 1 : 0;
    state_->is_first = false;
  }
  const bool is_last = done == total;
  if (!is_last && now - state_->shown_s < (state_->is_terminal ? 0.2 : 10)) return;
  state_->shown_s = now;
  const double elapsed = now - state_->started_s;
  const auto fresh = static_cast<double>(done - std::min(done, state_->done_at_start));
  const double left = fresh > 0 ? elapsed / fresh * static_cast<double>(total - done) : 0;
  const std::string time = is_last     ? in_words(elapsed)
                           : fresh > 0 ? "about " + in_words(left) + " left"
                                       : "";
  if (run_log.is_there) {
    const std::lock_guard<std::mutex> saying_lock(saying);
    run_log.add(fmt::format("{} {}/{} {} {}", state_->what, done, total, time, latest));
  }
  if (state_->is_terminal) {
    constexpr std::size_t kWidth = 28;
    const std::size_t filled = total ? kWidth * done / total : 0;
    to_stderr("\r\033[K{} [{}{}] {}/{} {} {}", state_->what, std::string(filled, '#'),
              std::string(kWidth - filled, '.'), done, total, time, latest);
    state_->has_bar = true;
  } else if (!run_log.is_there || loudness == Loudness::verbose) {
    to_stderr("{} {}/{} {} {}\n", state_->what, done, total, time, latest);
  }
  std::fflush(stderr);
}

}  // namespace palpate::tools

// METIS handles SIGABRT and SIGTERM of the whole process while it orders a matrix on one thread: a
// SIGTERM then made it order badly instead of interrupting, or jump into a stack that was gone. It
// keeps its handler of SIGABRT, by which it ends for want of memory, for the thread that calls
// it. A program's own definition precedes a shared library's. METIS of Debian 12 alone calls the
// first; the one in CHOLMOD of Debian 13 calls signal(), as others do for other purposes.
extern "C" sighandler_t __sysv_signal(int signal, sighandler_t handler) noexcept {
  if (signal == SIGABRT)
    palpate::tools::metis_abort = handler == palpate::tools::process_handler ? nullptr : handler;
  return palpate::tools::process_handler;
}
extern "C" sighandler_t signal(int signal, sighandler_t handler) noexcept {
  if ((signal == SIGABRT || signal == SIGTERM) && handler != SIG_DFL && handler != SIG_IGN)
    return __sysv_signal(signal, handler);
  struct sigaction action {
  }, before{};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART;
  return ::sigaction(signal, &action, &before) == 0 ? before.sa_handler : SIG_ERR;
}
