#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace palpate::tools {

/// What `palpate check asset.palp` was asked for.
struct AssetCheck {
  std::string asset, vtu, devices;  ///< vtu: a map to write; devices: a table beside the program's
  std::string repair;               ///< a repaired asset to write
  std::string device;               ///< whose stiffness the repair keeps within; empty: none's
  int jobs = 0;
};

/// The certificate as a paragraph and as an object.
struct AssetAnswer {
  bool is_certified = false;
  std::string text;
  nlohmann::ordered_json json;
};

/// Certifies an asset, or repairs it and certifies the repaired one, and writes the map. Throws
/// Error for a bad asset or table.
AssetAnswer check_asset(const AssetCheck& check);

}  // namespace palpate::tools
