#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "libfit/assets/exporters.hpp"
#include "libfit/runtime/asset/view.hpp"

namespace palpate {

/// The bytes of an asset in memory, 64-byte aligned as the engine wants them.
class AssetBytes {
 public:
  explicit AssetBytes(std::size_t size) : lines_(size / sizeof(Line)) {}
  std::size_t size() const { return lines_.size() * sizeof(Line); }
  unsigned char* data() { return lines_.empty() ? nullptr : lines_.front().byte; }
  const unsigned char* data() const { return lines_.empty() ? nullptr : lines_.front().byte; }

 private:
  struct alignas(64) Line {
    unsigned char byte[64] = {};
  };
  std::vector<Line> lines_;
};

/// An asset as it goes into a file: surface, curves, tree, check path with the engine's own forces.
/// Refusals as make_asset_surface's, plus bad bases. Fills the report where there is one.
/// Deterministic.
AssetBytes make_asset_bytes(const Model& model, const ExportOptions& options,
                            ExportReport* report = nullptr);

/// An asset with other meta data; its check path is recorded again. Throws Error where the
/// engine refuses the numbers.
AssetBytes with_meta(const runtime::AssetView& asset, const std::string& meta_json);

}  // namespace palpate
