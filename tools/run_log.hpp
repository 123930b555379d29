#pragma once

#include <filesystem>
#include <string>

namespace palpate::tools {

/// While it lives, notes and progress (console.hpp) go to a file instead of stderr, where they are
/// with --verbose alone; warnings go to both, on stderr each once. At most one lives. Defined in
/// console.cpp, beside what it diverts.
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

}  // namespace palpate::tools
