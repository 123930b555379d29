#include "libfit/assets/asset_file.hpp"

#include <algorithm>
#include <cstring>
#include <fstream>

#include "libfit/core/closest_point.hpp"
#include "libfit/core/error.hpp"
#include "libfit/io/atomic_file.hpp"

namespace palpate {

bool is_asset_file(const std::filesystem::path& path) {
  std::error_code ignored;
  const std::filesystem::file_status status = std::filesystem::status(path, ignored);
  if (!std::filesystem::exists(status))
    throw Error(path.string(), "no such file", "Check the name.");
  if (!std::filesystem::is_regular_file(status)) return false;
  std::ifstream file(path, std::ios::binary);
  if (!file)
    throw Error(path.string(), "the file cannot be read", "Check the name and the permissions.");
  char magic[4] = {};
  file.read(magic, sizeof magic);
  return file && std::memcmp(magic, "PALP", sizeof magic) == 0;
}

AssetFile read_asset_file(const std::filesystem::path& path) {
  const std::string content = read_whole_file(path);
  AssetFile out;
  out.bytes_ = AssetBytes(content.size());
  std::ranges::copy(content, reinterpret_cast<char*>(out.bytes_.data()));
  runtime::Status status;
  out.asset_ = runtime::Asset::open(out.bytes_.data(), content.size(), &status);
  if (status != runtime::Status::ok)
    throw Error(path.string(),
                std::string("the asset cannot be read: ") + runtime::sentence(status),
                "Give the path of a .palp file, made by `palpate export`.");
  return out;
}

Surface surface_of(const runtime::AssetView& asset) {
  Surface surface;
  const auto vertices = Eigen::Map<const Eigen::Matrix<float, -1, 3, Eigen::RowMajor>>(
      asset.vertex, asset.vertices, 3);
  surface.vertices = vertices.cast<double>();
  surface.vertices.rowwise() += Eigen::Map<const Vec3>(asset.origin_m).transpose();
  surface.triangles = Eigen::Map<const Triangles>(asset.triangle, asset.triangles, 3);
  return surface;
}

std::vector<runtime::VisualVertex> hang(const runtime::AssetView& asset, const Points& place_m) {
  const Surface surface = surface_of(asset);
  const BoxTree boxes = triangle_boxes(surface);
  std::vector<runtime::VisualVertex> visual;
  for (const Vec3 x : place_m.rowwise()) {
    const SurfacePoint at = *closest_point(surface, boxes, x);
    const auto corner = [&](int k) { return asset.vertex_at(asset.corner(at.triangle, k)); };
    const runtime::TriangleAxes axes(corner(0), corner(1), corner(2));
    const Vec3 off_m = x - at.position;
    const runtime::Vec3d off{off_m[0], off_m[1], off_m[2]};
    runtime::VisualVertex& hung = visual.emplace_back(
        runtime::VisualVertex{at.triangle, {float(at.weight[1]), float(at.weight[2])}, {}});
    for (int k = 0; k < 3; ++k) hung.offset_m[k] = float(dot(axes.axis[k], off));
  }
  return visual;
}

}  // namespace palpate
