#pragma once

#include <filesystem>

namespace palpate::tools {

/// Whether the file begins with an asset's magic. Throws Error when it cannot be read.
bool is_asset_file(const std::filesystem::path& path);

/// A screenful on stdout: version, sizes, curves, probe, meta.
void print_asset(const std::filesystem::path& path);

}  // namespace palpate::tools
