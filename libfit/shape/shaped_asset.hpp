#pragma once

#include <cstdint>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/runtime/engine.hpp"

namespace palpate {

/// A shape response in memory that the engine evaluates: the view of an asset with this response in
/// place of its own. Keeps what the view points to.
class ShapedAsset {
 public:
  /// blend_point, blend_weight: V x 3, of the asset's vertices, 0 where they are not covered.
  ShapedAsset(const runtime::AssetView& asset, const ShapeResponse& shape,
              const Triangles& blend_point, const Points& blend_weight);
  ShapedAsset(const ShapedAsset&) = delete;
  ShapedAsset& operator=(const ShapedAsset&) = delete;
  const runtime::AssetView& view() const { return view_; }

 private:
  runtime::AssetView view_;
  std::vector<std::int32_t> blend_point_;
  std::vector<float> blend_weight_, point_, drag_, mode_;
};

}  // namespace palpate
