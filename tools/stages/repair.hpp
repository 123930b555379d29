#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace palpate::tools {

struct RepairRequest {
  std::filesystem::path asset, output;  ///< may be the same
  int jobs = 0;                         ///< 0: all cores
  /// The statement of error that the asset carries is one of the repaired asset; false: it is kept
  /// as one of before.
  bool is_stated = false;
};

/// What was done, kind by kind, as sentences and as an object.
struct RepairAnswer {
  std::string text;
  nlohmann::ordered_json json;
};

/// Repairs an asset of rings (docs/method.md, section 19) and writes it with a note of what was
/// done. Throws Error for a bad asset or one that sliding is not certified for.
RepairAnswer repair_asset(const RepairRequest& request);

}  // namespace palpate::tools
