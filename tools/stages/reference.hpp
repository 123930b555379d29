#pragma once

#include <filesystem>
#include <string>

#include "libfit/core/body.hpp"
#include "libfit/validation/replay.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

struct ReferenceRequest {
  ValidateSection settings;
  int jobs = 0;
  /// Folder in which what is simulated is kept and looked for; empty: nowhere.
  std::filesystem::path folder;
  std::string fingerprint;  ///< point_fingerprint of the scene and the body
  bool resume = true;
};

/// Draws the held-out experiments of a scene and simulates them, but for those that the folder
/// holds already: `reference.h5` and `reference_own.h5`. An interruption (exception Interrupted)
/// keeps what is done.
validation::Reference simulate_reference(const Scene& scene, const Body& body,
                                         const ReferenceRequest& request);

}  // namespace palpate::tools
