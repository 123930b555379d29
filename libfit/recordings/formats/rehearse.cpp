// HDF5 1.10 reads freed memory, follows null pointers or loops on some damaged files
// (tests/fuzz/README.md), and a process that does so cannot say what it was reading.

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>

#include "libfit/core/error.hpp"
#include "libfit/recordings/formats/importers.hpp"

namespace palpate::importers {
namespace {

constexpr rlim_t kLongestCpu_s = 60;  // files of 100 MiB take a second

[[noreturn]] void be_child(const std::function<void()>& read) {
  const rlimit seconds{kLongestCpu_s, kLongestCpu_s}, no_core{0, 0};
  ::setrlimit(RLIMIT_CPU, &seconds);
  ::setrlimit(RLIMIT_CORE, &no_core);
  for (const int signal : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL}) ::signal(signal, SIG_DFL);
  try {
    read();
  } catch (...) {  // the parent meets the same and says it
  }
  ::_exit(0);
}

}  // namespace

void rehearse(const std::filesystem::path& path, const std::function<void()>& read) {
  const pid_t child = ::fork();
  if (child == 0) be_child(read);
  int status = 0;
  pid_t ended = child;
  while (child > 0 && (ended = ::waitpid(child, &status, 0)) < 0 && errno == EINTR) {
  }
  if (ended < 0)
    throw Error(path.string(), std::string("cannot be tried in a process: ") + std::strerror(errno),
                "Free some memory or processes.");
  if (status == 0) return;
  const bool is_slow =
      WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL);
  throw Error(path.string(),
              is_slow ? "is damaged: the HDF5 library does not come to an end on it"
                      : "is damaged: the HDF5 library crashes on it",
              "Save it again from its source, or copy what is left of it with h5repack.");
}

}  // namespace palpate::importers
