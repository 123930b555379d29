#include "libfit/assets/asset_file.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>

#include "libfit/core/error.hpp"

namespace palpate {
namespace {

class Descriptor {
 public:
  explicit Descriptor(const std::filesystem::path& path)
      : value_(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {}  // of a pipe, too
  ~Descriptor() {
    if (value_ >= 0) ::close(value_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return value_; }

 private:
  int value_;
};

[[noreturn]] void cannot_read(const std::filesystem::path& path, const std::string& why) {
  throw Error(path.string(), "the asset cannot be read: " + why,
              "Give the path of a .palp file, made by `palpate export`.");
}

}  // namespace

void AssetFile::Unmap::operator()(void* bytes) const noexcept { ::munmap(bytes, size); }

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
  const Descriptor file(path);
  struct stat about {};
  if (file.get() < 0 || ::fstat(file.get(), &about) != 0) cannot_read(path, std::strerror(errno));
  if (!S_ISREG(about.st_mode)) cannot_read(path, "it is not a file");
  if (about.st_size == 0) cannot_read(path, "it is empty");
  AssetFile out;
  const auto size = static_cast<std::size_t>(about.st_size);
  void* bytes = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.get(), 0);
  if (bytes == MAP_FAILED) cannot_read(path, std::strerror(errno));
  out.map_ = {bytes, AssetFile::Unmap{size}};
  runtime::Status status;
  out.asset_ = runtime::Asset::open(bytes, size, &status);
  if (status != runtime::Status::ok) cannot_read(path, runtime::sentence(status));
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
