#include "libfit/assets/asset_file.hpp"

#include <algorithm>
#include <cstring>
#include <fstream>

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

}  // namespace palpate
