#pragma once

#include "libfit/core/shape_arrays.hpp"
#include "libfit/runtime/engine.hpp"

namespace palpate {

/// A shape response in memory that the engine evaluates: the view of an asset with this response in
/// place of its own. Keeps what the view points to.
class ShapedAsset {
 public:
  /// blend_point, blend_weight: V x 3, of the asset's vertices, 0 where they are not covered.
  ShapedAsset(const runtime::AssetView& asset, const ShapeResponse& shape,
              const Triangles& blend_point, const Points& blend_weight)
      : view_(asset),
        arrays_(shape_arrays(shape, asset.covered, asset.record, asset.records, blend_point,
                             blend_weight)) {
    view_.shape = {arrays_.header,       arrays_.blend_point.data(), arrays_.blend_weight.data(),
                   arrays_.point.data(), arrays_.drag.data(),        arrays_.mode.data()};
  }
  ShapedAsset(const ShapedAsset&) = delete;
  ShapedAsset& operator=(const ShapedAsset&) = delete;
  const runtime::AssetView& view() const { return view_; }

 private:
  runtime::AssetView view_;
  ShapeArrays arrays_;
};

}  // namespace palpate
