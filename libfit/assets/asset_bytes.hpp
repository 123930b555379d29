#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "libfit/assets/exporters.hpp"
#include "libfit/runtime/asset/view.hpp"

namespace palpate {

/// The bytes of an asset in memory, 64-byte aligned as the engine wants them.
class AssetBytes {
 public:
  explicit AssetBytes(std::size_t size = 0) : lines_((size + 63) / sizeof(Line)) {}
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

/// An asset that moves these vertices with its surface, in place of those that it moved before.
AssetBytes with_visual(const runtime::AssetView& asset,
                       const std::vector<runtime::VisualVertex>& visual);

/// A model's surface and curves rounded to what an asset stores. V vertices, F triangles.
/// Arrays as in libfit/runtime/asset/format.hpp.
struct AssetSurface {
  Vec3 origin;                        ///< [m], centre of the bounding box
  std::vector<float> vertex;          ///< V x 3 [m] about the origin
  std::vector<float> normal;          ///< V x 3, inward unit
  std::vector<std::uint8_t> covered;  ///< V: kMeasured, kMean or 0
  /// V: row of control. Measured vertices have one each, the mean and nothing one if there are any.
  std::vector<std::int32_t> record;
  std::vector<float> control;                     ///< R x the family's parts, 0 for nothing
  std::vector<std::int32_t> recorded;             ///< R: a vertex that answers so
  std::vector<std::int32_t> triangle, neighbour;  ///< F x 3
  std::vector<float> max_depth_m;                 ///< F, 0: air
  std::vector<std::int32_t> measured_triangles;   ///< solid ones with a measured corner
  double diagonal_m = 0;                          ///< of the bounding box

  ExportReport report;  ///< its counts of vertices and triangles
};

/// Rounds a model to its asset's arrays, finds neighbours, and bounds each triangle's depth.
/// Vertices on an open border answer with zero where options.fades_borders, those without test
/// points with the mean where options.has_mean_elsewhere.
/// Throws Error, naming the model's element, when: nothing is covered; array sizes differ; a number
/// is not finite; a normal of a covered vertex is not unit; a triangle names a missing vertex or
/// one twice; an edge has three triangles, or two along it in one direction; a curve decreases.
AssetSurface make_asset_surface(const Model& model, const ExportOptions& options);

/// Vector i of an array of three floats each.
inline Vec3 vector_at(const std::vector<float>& array, std::size_t i) {
  return Eigen::Map<const Eigen::Vector3f>(&array[3 * i]).cast<double>();
}

/// Triangle across the edge from corner k to k+1 of each triangle, -1 at borders. F x 3.
/// Throws Error on an edge with three triangles or two along it in one direction.
std::vector<std::int32_t> triangle_neighbours(const Triangles& triangles);

}  // namespace palpate
