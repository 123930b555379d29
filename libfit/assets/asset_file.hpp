#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string_view>

#include "libfit/core/geometry.hpp"
#include "libfit/runtime/engine.hpp"

namespace palpate {

/// An asset file mapped into memory and checked: what tools replay, check and inspect.
class AssetFile {
 public:
  const runtime::Asset& asset() const { return asset_; }
  std::string_view meta_json() const { return {asset_.file.meta, asset_.file.meta_bytes}; }
  std::size_t bytes() const { return asset_.file.bytes; }

 private:
  friend AssetFile read_asset_file(const std::filesystem::path& path);
  struct Unmap {
    std::size_t size;
    void operator()(void* bytes) const noexcept;
  };
  std::unique_ptr<void, Unmap> map_;
  runtime::Asset asset_;
};

/// True where the file begins with an asset's magic. Throws Error when it cannot be read.
bool is_asset_file(const std::filesystem::path& path);

/// Maps an asset file read-only and opens it, check path included. Safe on any file that nobody
/// changes while it is open. Throws Error when it cannot be read or the engine refuses it, with
/// the engine's sentence.
AssetFile read_asset_file(const std::filesystem::path& path);

/// The surface that an asset walks on, at rest.
Surface surface_of(const runtime::AssetView& asset);

}  // namespace palpate
