#pragma once

#include <string>

#include "libfit/assets/asset_file.hpp"

namespace palpate::tools {

/// What an asset is, as a page for people, 80 columns wide but for long names: its body and window,
/// probe, curves, certificate, statement and size. What the file does not hold is said to be so.
std::string page_of(const std::string& name, const AssetFile& file);

}  // namespace palpate::tools
