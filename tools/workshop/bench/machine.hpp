#pragma once

// What benchmarks say of the machine and of what they took of it.

#include <time.h>

#include <fstream>
#include <string>

namespace palpate::tools {

/// The processor's name.
inline std::string machine() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

/// CPU of all threads so far [s]: unlike the clock's, other work on the machine adds little to it.
inline double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// The most memory that the process had since forget_peak() [MiB]; since it began where that is
/// refused.
inline double peak_MiB() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.rfind("VmHWM:", 0) == 0) return std::stod(line.substr(6)) / 1024;
  return 0;
}
inline void forget_peak() { std::ofstream("/proc/self/clear_refs") << 5; }

}  // namespace palpate::tools
