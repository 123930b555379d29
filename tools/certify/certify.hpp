#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace palpate::tools {

/// What `palpate check asset.palp` was asked for.
struct AssetCheck {
  std::string asset, vtu, devices;  ///< vtu: a map to write; devices: a table beside the program's
  std::string tool;                 ///< a scene whose [probe] meets it; empty: the asset's own ball
  int jobs = 0;
};

/// The certificate as a paragraph and as an object.
struct AssetAnswer {
  bool is_certified = false;
  std::string text;
  nlohmann::ordered_json json;
};

/// Certifies an asset and writes the map. Throws Error for a bad asset or table.
AssetAnswer check_asset(const AssetCheck& check);

}  // namespace palpate::tools
