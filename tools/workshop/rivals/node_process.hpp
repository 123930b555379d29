#pragma once

#include <sys/types.h>

#include <cstdio>
#include <filesystem>
#include <string>

namespace palpate::tools {

/// A script that Node runs beside this process, talked to line by line.
class NodeProcess {
 public:
  /// folder: where the script's packages are found (node_modules in it).
  NodeProcess(const std::string& script, const std::filesystem::path& folder);
  ~NodeProcess();
  NodeProcess(const NodeProcess&) = delete;

  /// Sends a line and returns the next one that begins with "= ", without that; empty where the
  /// script has ended.
  std::string ask(const std::string& line);

 private:
  pid_t child_ = -1;
  std::FILE *to_ = nullptr, *from_ = nullptr;
};

}  // namespace palpate::tools
