#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/runtime/engine.hpp"

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

/// The engine's contact at each row of the samples, every experiment replayed from outside at 20 um
/// a tick; a drag is first pressed to its depth. Empty where a row is not good, nothing touches, or
/// an earlier row of its experiment was not good. depth_m: loading begins a tenth of it outside.
std::vector<std::optional<runtime::Contact>> contact_states(const runtime::AssetView& asset,
                                                            const Samples& samples, double depth_m);

/// Quantiles of the distance between where the engine shows vertices and where the reference has
/// them [m], and the same over the depth of the row. NaN where there is no such vertex.
struct ShapeErrorFigures {
  double median_m = 0, p95_m = 0, max_m = 0;
  double median_rel = 0, p95_rel = 0, max_rel = 0;
};

/// near: vertices within three contact radii of the contact point; all: every vertex. 0 rows:
/// nothing was compared.
struct ShapeError {
  ShapeErrorFigures near, all;
  std::size_t rows = 0;
};

/// Compares the engine with the motion of the surface in the rows of the samples, in contacts as
/// contact_states brings them. The depth that errors are shares of is
/// at least a tenth of the deepest that the response knows. is_shown: with the ball pushing
/// vertices out, as palpate_deform does.
ShapeError shape_error(const runtime::AssetView& asset, const Samples& samples,
                       const std::vector<std::optional<runtime::Contact>>& contacts,
                       bool is_shown = true);

/// depth_m: deepest press. radius_m: contact radius there, which goes as d^(radius_power / 2).
struct ShapeOptions {
  double depth_m = 0, radius_m = 0;
  int radius_power = 1;
  int intervals = 16;  ///< 10 leave 1.4 times the error on the liver phantom, 24 as much
  /// At most; a mode is 12 bytes a vertex. On points left out of twelve bodies 6 leave at most a
  /// tenth more than the best of 0 to 24 did within a fifth, and on eight of them less.
  int modes = 6;
};

/// The shape response of a body from the motion of its surface at test points (docs/method-body.md,
/// section 20). asset: without one, of the same model; blend_point, blend_weight: the model's.
/// samples.surface must have 3V columns. No points where no press at a test point is known.
/// Does not depend on the number of threads.
ShapeResponse identify_shape(const runtime::AssetView& asset, const Samples& samples,
                             const Triangles& blend_point, const Points& blend_weight,
                             const ShapeOptions& options);

}  // namespace palpate
