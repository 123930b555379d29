#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace palpate::tools {

/// What each recording of a manifest is, and what is wrong with it.
struct CheckedManifest {
  std::string text;             ///< a line each, then what the points are and what is held out
  nlohmann::ordered_json json;  ///< the same, with what `import` tells
  std::size_t refused = 0;
};

/// Reads and places all recordings as `import` does and writes nothing. Refusals and notes are said
/// on stderr. Throws Error on what `import` would refuse as a whole,
/// and where no recording can be used.
CheckedManifest check_manifest(const std::filesystem::path& manifest, int jobs);

}  // namespace palpate::tools
