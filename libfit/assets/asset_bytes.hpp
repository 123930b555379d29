#pragma once

#include <cstddef>
#include <vector>

#include "libfit/assets/exporters.hpp"

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
/// Refusals as make_asset_surface's, plus bad bases. Fills the report when given. Deterministic.
AssetBytes make_asset_bytes(const Model& model, const ExportOptions& options,
                            ExportReport* report = nullptr);

/// The engine, on the asset's own bytes, says what its check path must bring; the bytes are sealed.
/// For bytes that are new or changed. Returns how many ticks have a force. Throws Error where the
/// engine refuses the numbers.
int record_check_forces(AssetBytes& bytes);

}  // namespace palpate
