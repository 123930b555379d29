#include <string>

#include "libfit/assets/exporters.hpp"
#include "libfit/assets/stiffness_map.hpp"
#include "libfit/io/atomic_file.hpp"

namespace palpate {
namespace {

template <class T>
void append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace

/// Source: Turk, The PLY Polygon File Format (1994); binary, little-endian.
ExportReport export_ply(const Model& model, const std::filesystem::path& path,
                        const ExportOptions& options) {
  const StiffnessMap map = stiffness_map(model, options.map_depth_m);
  const Surface& surface = model.surface;
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\ncomment palpate: metres; normal stiffness at a depth "
      "of " +
      std::to_string(map.depth_m) + " m, coloured from " + std::to_string(map.low_N_m) + " to " +
      std::to_string(map.high_N_m) +
      " N/m; grey and NaN where nothing was measured\nelement vertex " +
      std::to_string(surface.vertices.rows()) +
      "\nproperty double x\nproperty double y\nproperty double z\nproperty uchar red\n"
      "property uchar green\nproperty uchar blue\nproperty float normal_stiffness_N_m\nelement "
      "face " +
      std::to_string(surface.triangles.rows()) +
      "\nproperty list uchar int vertex_indices\nend_header\n";
  for (Eigen::Index v = 0; v < surface.vertices.rows(); ++v) {
    for (int k = 0; k < 3; ++k) append(bytes, surface.vertices(v, k));
    for (const std::uint8_t part : map.colour[v]) append(bytes, part);
    append(bytes, map.stiffness_N_m[v]);
  }
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    append(bytes, std::uint8_t{3});
    for (int k = 0; k < 3; ++k) append(bytes, surface.triangles(t, k));
  }
  write_file_atomically(path, bytes);
  return written(model, bytes.size());
}

}  // namespace palpate
