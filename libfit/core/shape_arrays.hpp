#pragma once

#include <cstdint>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/runtime/asset/view.hpp"

namespace palpate {

/// The shape response as an asset stores it; no points: none.
struct ShapeArrays {
  runtime::ShapeHeader header{};
  std::vector<std::int32_t> blend_point;  ///< three of each record, 0 where nothing was measured
  std::vector<float> blend_weight, point, drag, mode;
};

/// covered, record: of each vertex, as in an asset. blend_point, blend_weight: V x 3.
inline ShapeArrays shape_arrays(const ShapeResponse& shape, const std::uint8_t* covered,
                                const std::int32_t* record, std::size_t records,
                                const Triangles& blend_point, const Points& blend_weight) {
  ShapeArrays out;
  out.header = {std::int32_t(shape.point.rows()),
                shape.intervals,
                shape.modes,
                shape.radius_power,
                shape.depth_m,
                shape.radius_m,
                {}};
  out.blend_point.assign(3 * records, 0);
  out.blend_weight.assign(3 * records, 0);
  for (Eigen::Index v = 0; v < blend_point.rows(); ++v)
    for (int k = 0; k < 3 && covered[v] == runtime::kMeasured; ++k) {
      out.blend_point[3 * record[v] + k] = blend_point(v, k);
      out.blend_weight[3 * record[v] + k] = float(blend_weight(v, k));
    }
  const auto floats = [](const auto& values) {
    return std::vector<float>(values.data(), values.data() + values.size());
  };
  out.point = floats(shape.point);
  out.drag = floats(shape.drag);
  out.mode = floats(shape.mode);
  return out;
}

}  // namespace palpate
