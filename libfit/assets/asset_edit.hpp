#pragma once

#include <string>
#include <vector>

#include "libfit/assets/asset_bytes.hpp"
#include "libfit/runtime/asset.hpp"

namespace palpate {

/// An asset whose numbers change in place: controls and normals of its vertices. Triangles, what is
/// measured and everything else stay.
class AssetEdit {
 public:
  /// A copy of an opened asset's bytes.
  explicit AssetEdit(const runtime::AssetView& asset);

  /// The asset as it stands. Its pointers see changes at once; `seal` makes it whole again.
  const runtime::Asset& asset() const { return asset_; }
  const AssetBytes& bytes() const { return bytes_; }

  /// Writable controls [controls_per_vertex] and inward unit normal [3] of a vertex.
  float* node(int vertex);
  float* normal(int vertex);

  /// Bounds the depths of triangles whose normals turned, records the check path and opens the
  /// asset again: pointers of before are void. Throws Error where the engine refuses the numbers.
  void seal();
  /// The same with other meta data.
  void seal(const std::string& meta_json);

 private:
  float* section(runtime::Section which);
  void open();
  AssetBytes bytes_;
  runtime::Asset asset_;
  std::vector<char> has_turned_;  // of a vertex: its normal is changed since the last seal
};

}  // namespace palpate
