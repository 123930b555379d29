#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "libfem/solve/experiments/simulator.hpp"
#include "libfit/core/samples.hpp"

namespace palpate::tools {

/// Where paths that are simulated are kept.
struct KeptPaths {
  std::string what;  ///< for messages and progress
  int jobs = 0;
  std::filesystem::path output;  ///< empty: nowhere
  std::string fingerprint;       ///< of all that the rows depend on
  bool resume = true;            ///< go on with what the output, or OUTPUT.partial, has
};

/// Simulates paths at their points, numbered in the order given, into the output with its
/// fingerprint. What is done is kept in OUTPUT.partial from the first path on, and neither a signal
/// nor a kill loses it. Throws Interrupted.
Samples simulate_kept_paths(const fem::Simulator& simulator, const TestPoints& points,
                            const std::vector<ToolPath>& paths, const KeptPaths& request);

}  // namespace palpate::tools
