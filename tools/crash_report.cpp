#include "tools/console.hpp"

#include <execinfo.h>
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>

namespace palpate::tools {
namespace {

constexpr std::pair<int, std::string_view> kSignals[] = {{SIGSEGV, "SIGSEGV"},
                                                         {SIGILL, "SIGILL"},
                                                         {SIGBUS, "SIGBUS"},
                                                         {SIGFPE, "SIGFPE"},
                                                         {SIGABRT, "SIGABRT"}};

// Text of fixed size: a handler may not allocate. What does not fit is cut.
template <std::size_t Bytes>
struct FixedText {
  char bytes[Bytes] = {};  // ends with a zero
  std::size_t size = 0;

  FixedText& operator=(std::string_view text) {
    size = 0;
    return *this += text;
  }
  FixedText& operator+=(std::string_view text) {
    size += text.copy(bytes + size, Bytes - 1 - size);
    bytes[size] = '\0';
    return *this;
  }
  operator std::string_view() const { return {bytes, size}; }
};

FixedText<256> build_text, stage_text;
FixedText<4096> crash_file;
constinit thread_local FixedText<256> item_text;
bool is_terminal = false;
constinit thread_local sighandler_t metis_abort = nullptr;
void process_handler(int) {}              // stands for what METIS would put back when it has ended
alignas(16) char handler_stack[1 << 16];  // of the main thread, whose own may have overflowed

void write_text(int file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(file, text.data(), text.size());
    if (written <= 0) return;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

// Copies the beginning of a file, up to `end`, with blanks for zeros.
void write_file(int to, const char* title, const char* path, std::string_view end) {
  static char bytes[1 << 14];
  const int file = ::open(path, O_RDONLY | O_CLOEXEC);
  std::size_t size = 0;
  for (ssize_t got = 1; file >= 0 && got > 0 && size < sizeof bytes;) {
    got = ::read(file, bytes + size, sizeof bytes - size);
    size += static_cast<std::size_t>(std::max<ssize_t>(got, 0));
  }
  std::replace(bytes, bytes + size, '\0', ' ');
  write_text(to, title);
  write_text(to, std::string_view(bytes, size).substr(0, std::string_view(bytes, size).find(end)));
  write_text(to, "\n");
}

// Calls nothing but functions that are safe in a signal handler, and last those that walk the
// stack: if they die of what is wrong with it, the rest is written.
void on_crash(int signal) {
  if (signal == SIGABRT && metis_abort != nullptr) metis_abort(signal);
  static std::atomic_flag is_reporting;
  while (is_reporting.test_and_set()) ::pause();  // the thread that came first ends the program
  FixedText<1024> line;
  line += "palpate: crashed (";
  line += std::ranges::find(kSignals, signal, &std::pair<int, std::string_view>::first)->second;
  line += ") in ";
  line += stage_text;
  if (item_text.size > 0) line += ", ";
  line += item_text;
  const int opened = ::open(crash_file.bytes, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  const int file = opened < 0 ? STDERR_FILENO : opened;
  if (is_terminal) write_text(STDERR_FILENO, "\n");  // after a progress bar
  write_text(STDERR_FILENO, line);
  write_text(STDERR_FILENO, ": please send ");
  write_text(STDERR_FILENO, opened < 0 ? std::string_view("all of this") : crash_file);
  write_text(STDERR_FILENO, " and what the command reads; what is finished is kept\n");
  if (opened >= 0) write_text(file, line);
  write_text(file, "\nbuild: ");
  write_text(file, build_text);
  write_file(file, "\ncommand: ", "/proc/self/cmdline", "\n");
  write_file(file, "system: ", "/etc/os-release", "\n");
  write_file(file, "processor:\n", "/proc/cpuinfo", "\n\n");
  write_text(file, "stack:\n");
  void* frames[64];
  ::backtrace_symbols_fd(frames, ::backtrace(frames, std::size(frames)), file);
  write_text(file, "\n");
  std::signal(signal, SIG_DFL);
  std::raise(signal);  // waits until this handler returns
}

}  // namespace

void report_crashes(std::string_view build) {
  build_text = build;
  stage_text = "the command line";
  set_crash_file("");
  is_terminal = ::isatty(STDERR_FILENO) != 0;
  void* frame = nullptr;
  ::backtrace(&frame, 1);  // loads what walks the stack, which a handler may not
  stack_t stack{};
  stack.ss_sp = handler_stack;
  stack.ss_size = sizeof handler_stack;
  ::sigaltstack(&stack, nullptr);
  struct sigaction action {
  }, before{};
  action.sa_handler = on_crash;
  action.sa_flags = SA_ONSTACK;
  ::sigemptyset(&action.sa_mask);
  // A signal that the handler itself brings on then ends the program at once.
  for (const auto& [signal, name] : kSignals) ::sigaddset(&action.sa_mask, signal);
  for (const auto& [signal, name] : kSignals)
    if (::sigaction(signal, nullptr, &before) == 0 && before.sa_handler == SIG_DFL)
      ::sigaction(signal, &action, nullptr);
}

void set_crash_file(std::string_view output) {
  namespace fs = std::filesystem;
  fs::path path = fs::absolute(output.empty() ? "palpate" : output).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();  // "out/"
  crash_file = path.string() + ".crash.txt";
}

void set_stage(std::string_view stage) { stage_text = stage; }
void set_item(std::string_view item) { item_text = item; }

}  // namespace palpate::tools

// METIS handles SIGABRT and SIGTERM of the whole process while it orders a matrix on one thread: a
// SIGTERM then made it order badly instead of interrupting, or jump into a stack that was gone. It
// keeps its handler of SIGABRT, by which it gives up for want of memory, for the thread that calls
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
