#pragma once

#include <cstddef>
#include <filesystem>
#include <string_view>

#include "libfit/assets/asset_bytes.hpp"
#include "libfit/core/geometry.hpp"
#include "libfit/runtime/engine.hpp"

namespace palpate {

/// An asset file in memory and checked: what tools replay, check and inspect.
class AssetFile {
 public:
  const runtime::Asset& asset() const { return asset_; }
  std::string_view meta_json() const { return {asset_.file.meta, asset_.file.meta_bytes}; }
  std::size_t bytes() const { return asset_.file.bytes; }

 private:
  friend AssetFile read_asset_file(const std::filesystem::path& path);
  AssetBytes bytes_;
  runtime::Asset asset_;
};

/// True where the file begins with an asset's magic. Throws Error when it cannot be read.
bool is_asset_file(const std::filesystem::path& path);

/// Reads an asset file and opens it, check path included. Safe on any file. Throws Error when it
/// cannot be read or the engine refuses it, with the engine's sentence.
AssetFile read_asset_file(const std::filesystem::path& path);

/// The surface that an asset walks on, at rest.
Surface surface_of(const runtime::AssetView& asset);

/// Hangs each place [m, in the body's frame] on the nearest place of the asset's surface, of two as
/// near on the lower triangle. place_m: # x 3, finite. Returns #, in the same order.
std::vector<runtime::VisualVertex> hang(const runtime::AssetView& asset, const Points& place_m);

}  // namespace palpate
