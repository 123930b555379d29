#include "libfit/shape/shaped_asset.hpp"

namespace palpate {
namespace {

std::vector<float> floats_of(const double* from, Eigen::Index count) {
  std::vector<float> out;
  for (Eigen::Index i = 0; i < count; ++i) out.push_back(static_cast<float>(from[i]));
  return out;
}

}  // namespace

ShapedAsset::ShapedAsset(const runtime::AssetView& asset, const ShapeResponse& shape,
                         const Triangles& blend_point, const Points& blend_weight)
    : view_(asset) {
  blend_point_.assign(3 * static_cast<std::size_t>(asset.records), 0);
  blend_weight_.assign(blend_point_.size(), 0.0F);
  for (int v = 0; v < asset.vertices; ++v)
    for (int k = 0; k < 3 && asset.covered[v] == runtime::kMeasured; ++k) {
      const auto at = static_cast<std::size_t>(3 * asset.record[v] + k);
      blend_point_[at] = blend_point(v, k);
      blend_weight_[at] = static_cast<float>(blend_weight(v, k));
    }
  point_ = floats_of(shape.point.data(), shape.point.size());
  drag_ = floats_of(shape.drag.data(), shape.drag.size());
  mode_ = floats_of(shape.mode.data(), shape.mode.size());
  view_.shape = {{static_cast<std::int32_t>(shape.point.rows()),
                  shape.intervals,
                  shape.modes,
                  shape.radius_power,
                  shape.depth_m,
                  shape.radius_m,
                  {}},
                 blend_point_.data(),
                 blend_weight_.data(),
                 point_.data(),
                 drag_.data(),
                 mode_.data()};
}

}  // namespace palpate
