#pragma once

#include <string>

namespace palpate::tools {

/// What `palpate check asset.palp` was asked for.
struct AssetCheck {
  std::string asset, vtu, devices;  ///< vtu: a map to write; devices: a table beside the program's
  bool json = false;
  int jobs = 0;
};

/// Certifies an asset, prints the paragraph or the object, writes the map. True where the asset is
/// certified. Throws Error for a bad asset or table.
bool check_asset(const AssetCheck& check);

}  // namespace palpate::tools
