#pragma once

#include <string>

#include "libfit/validation/statement.hpp"

namespace palpate::tools {

class RunLog;

/// What `palpate run` is asked for. scene: or a manifest. jobs: threads, 0 for all cores.
struct RunRequest {
  std::string scene, folder;
  int jobs = 0;
  bool force = false, quick = false;
};

inline constexpr const char* kRunLog = "run.log";

struct RunResult {
  int stages_done = 0;
  std::size_t items_failed = 0;  ///< experiments, points, held-out rows; each is said
  validation::Statement statement;
};

/// All stages from a scene or a manifest of recordings to an asset and its statement, those that
/// are up to date left out (docs/formats/run.md). Keeps a second run out of the folder. log: opened
/// in the folder as kRunLog; a line a stage stays on stderr.
RunResult run(const RunRequest& request, RunLog* log = nullptr);

}  // namespace palpate::tools
