#include "libfem/mesh/fill/fill_steps.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <exception>
#include <new>
#include <optional>
#include <thread>

#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"

namespace palpate {
namespace {

enum ChildStatus : int { kExitMesh = 0, kExitReason = 3, kExitNoMemory = 4 };
// Signals that a mesher brings on itself; any other came from outside.
constexpr int kOwnFaults[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};

/// The child leaves in the shared file a header, then nodes, tets and a text.
struct ResultHeader {
  std::int64_t nodes = 0, tets = 0, text_bytes = 0;
};

bool write_all(int file, const void* data, std::size_t bytes) {
  const char* at = static_cast<const char*>(data);
  while (bytes > 0) {
    const ssize_t written = ::write(file, at, bytes);
    if (written <= 0) return false;
    at += written;
    bytes -= static_cast<std::size_t>(written);
  }
  return true;
}

bool read_all(int file, void* data, std::size_t bytes, off_t offset) {
  char* at = static_cast<char*>(data);
  while (bytes > 0) {
    const ssize_t got = ::pread(file, at, bytes, offset);
    if (got <= 0) return false;
    at += got;
    offset += got;
    bytes -= static_cast<std::size_t>(got);
  }
  return true;
}

bool write_result(int file, const TetMesh& mesh, const std::string& reason) {
  const ResultHeader header{mesh.nodes.rows(), mesh.tets.rows(), std::ssize(reason)};
  return write_all(file, &header, sizeof header) &&
         write_all(file, mesh.nodes.data(), sizeof(double) * std::size_t(mesh.nodes.size())) &&
         write_all(file, mesh.tets.data(), sizeof(std::int32_t) * std::size_t(mesh.tets.size())) &&
         write_all(file, reason.data(), reason.size());
}

std::variant<TetMesh, std::string> read_result(int file, bool is_mesh) {
  const char* incomplete = "left an incomplete result";
  ResultHeader header;
  const off_t size = ::lseek(file, 0, SEEK_END);
  if (!read_all(file, &header, sizeof header, 0)) return incomplete;
  const off_t nodes_at = sizeof header, tets_at = nodes_at + header.nodes * off_t{24},
              text_at = tets_at + header.tets * off_t{16};
  if (header.nodes < 0 || header.tets < 0 || header.text_bytes < 0 ||
      size != text_at + header.text_bytes)
    return incomplete;
  TetMesh mesh{Points(header.nodes, 3), Tets(header.tets, 4), {}};
  std::string reason(static_cast<std::size_t>(header.text_bytes), ' ');
  if (!read_all(file, mesh.nodes.data(), static_cast<std::size_t>(tets_at - nodes_at), nodes_at) ||
      !read_all(file, mesh.tets.data(), static_cast<std::size_t>(text_at - tets_at), tets_at) ||
      !read_all(file, reason.data(), reason.size(), text_at))
    return incomplete;
  if (is_mesh) return mesh;
  return reason;
}

/// Handlers, output and limits of the parent do not belong to the child.
void isolate_child(double safety_limit_s) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  for (const int signal : kOwnFaults) ::signal(signal, SIG_DFL);
  for (const int signal : {SIGTERM, SIGALRM}) ::signal(signal, SIG_DFL);
  ::signal(SIGINT, SIG_IGN);
  const rlimit none{0, 0};
  ::setrlimit(RLIMIT_CORE, &none);
  const auto seconds =
      static_cast<rlim_t>(safety_limit_s) + 5;  // should the parent be gone or stopped
  const rlimit cpu{seconds, seconds};
  ::setrlimit(RLIMIT_CPU, &cpu);
  const int null = ::open("/dev/null", O_RDWR);
  for (int stream = 0; stream <= 2 && null >= 0; ++stream) ::dup2(null, stream);
}

[[noreturn]] void be_child(const std::function<TetMesh()>& mesher,
                           const std::function<std::string(int)>& thrown_int, int file,
                           double safety_limit_s) {
  isolate_child(safety_limit_s);
  std::string reason;
  try {
    const TetMesh mesh = mesher();
    ::_exit(write_result(file, mesh, {}) ? kExitMesh : kExitNoMemory);
  } catch (const std::bad_alloc&) {
    ::_exit(kExitNoMemory);
  } catch (const int code) {
    reason = thrown_int(code);
  } catch (const std::exception& error) {
    reason = error.what();
  } catch (...) {
    reason = "threw something unknown";
  }
  ::_exit(write_result(file, {}, reason) ? kExitReason : kExitNoMemory);
}

/// CPU time that the child has used [s].
double cpu_seconds_of(pid_t child) {
  clockid_t clock{};
  timespec time{};
  if (::clock_getcpuclockid(child, &clock) != 0 || ::clock_gettime(clock, &time) != 0) return 0;
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Waits until the child ends; nothing when it had to be killed: on a busy machine only the CPU
/// time that it used counts, but one that sleeps is not waited for without end.
std::optional<int> wait_for(pid_t child, double safety_limit_s) {
  using Clock = std::chrono::steady_clock;
  const auto deadline = Clock::now() + std::chrono::duration<double>(20 * safety_limit_s);
  for (;;) {
    int status = 0;
    const pid_t ended = ::waitpid(child, &status, WNOHANG);
    if (ended == child) return status;
    if (ended < 0 && errno != EINTR) return 0;  // reaped elsewhere: the result's own check decides
    if (cpu_seconds_of(child) > safety_limit_s || Clock::now() > deadline) {
      ::kill(child, SIGKILL);
      ::waitpid(child, &status, 0);
      return std::nullopt;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

[[noreturn]] void fail(const std::string& what, const std::string& remedy) {
  throw Error("filling the surface", "the mesher " + what, remedy);
}

/// Closes on leaving.
struct ScopedFile {
  int descriptor;
  ~ScopedFile() {
    if (descriptor >= 0) ::close(descriptor);
  }
};

}  // namespace

std::variant<TetMesh, std::string> run_in_child(const std::function<TetMesh()>& mesher,
                                                const std::function<std::string(int)>& thrown_int,
                                                double safety_limit_s) {
  const std::string memory_remedy =
      "Free some memory, or make mesh_size in [body] larger: no other setting of the mesher is "
      "tried, for the body must not differ between machines.";
  const ScopedFile file{::memfd_create("palpate-mesh", MFD_CLOEXEC)};
  if (file.descriptor < 0) fail("found no memory for its result", memory_remedy);
  const pid_t child = ::fork();
  if (child < 0) fail(std::string("could not be started: ") + std::strerror(errno), memory_remedy);
  if (child == 0) be_child(mesher, thrown_int, file.descriptor, safety_limit_s);

  const auto status = wait_for(child, safety_limit_s);
  if (!status || (WIFSIGNALED(*status) && WTERMSIG(*status) == SIGXCPU))
    fail("had not ended after its safety limit of " + number(safety_limit_s, 6) + " CPU seconds",
         "Make mesh_size in [body] larger, or simplify the surface in a mesh editor.");
  if (WIFSIGNALED(*status)) {
    const int signal = WTERMSIG(*status);
    const std::string what =
        "stopped on signal " + std::to_string(signal) + " (" + ::strsignal(signal) + ")";
    if (std::ranges::count(kOwnFaults, signal) > 0) return what;
    fail(what + " from outside, as where memory runs out", memory_remedy);
  }
  const int code = WEXITSTATUS(*status);
  if (code == kExitNoMemory) fail("ran out of memory", memory_remedy);
  if (code != kExitMesh && code != kExitReason)
    return "ended with exit status " + std::to_string(code);
  return read_result(file.descriptor, code == kExitMesh);
}

}  // namespace palpate
