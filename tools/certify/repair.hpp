#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace palpate::tools {

struct RepairRequest {
  std::filesystem::path asset, output;  ///< may be the same
  int jobs = 0;                         ///< 0: all cores
  std::string device = {};  ///< before the repair, curves are kept as soft as it shows; empty: no
  std::filesystem::path devices = {};  ///< a table beside the program's
};

/// What was done, kind by kind, as sentences and as an object.
struct RepairAnswer {
  std::string text;
  nlohmann::ordered_json json;
};

/// Repairs an asset of rings (docs/method.md, section 19) and writes it with a note of what was
/// done; a statement of error that the asset carries is kept as one of before. Throws Error for a
/// bad asset or one that sliding is not certified for.
RepairAnswer repair_asset(const RepairRequest& request);

}  // namespace palpate::tools
