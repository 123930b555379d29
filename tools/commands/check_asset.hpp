#pragma once

#include <string>

#include "tools/command.hpp"

namespace palpate::tools {

/// What `palpate check asset.palp` was asked for.
struct AssetCheck {
  std::string asset, devices;  ///< devices: a table beside the program's
  std::string tool;            ///< a scene whose [probe] meets it; empty: the asset's own ball
};

/// The certificate as a paragraph and as an object.
struct AssetAnswer {
  bool is_passive = false;
  Reply reply;
};

/// Throws Error for a bad asset, table or scene.
AssetAnswer check_asset(const AssetCheck& check);

}  // namespace palpate::tools
