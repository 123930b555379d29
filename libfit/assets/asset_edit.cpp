#include "libfit/assets/asset_edit.hpp"

#include <algorithm>
#include <cstring>

#include "libfit/assets/asset_surface.hpp"
#include "libfit/core/error.hpp"

namespace palpate {
namespace {

using runtime::Header;

Header header_of(const AssetBytes& bytes) {
  Header header;
  std::memcpy(&header, bytes.data(), sizeof header);
  return header;
}

Vec3 row(const float* array, int i) {
  return Eigen::Map<const Eigen::Vector3f>(array + 3 * std::ptrdiff_t{i}).cast<double>();
}

double diagonal_m(const runtime::AssetView& asset) {
  return (Eigen::Map<const Eigen::Vector3f>(asset.tree[0].hi) -
          Eigen::Map<const Eigen::Vector3f>(asset.tree[0].lo))
      .cast<double>()
      .norm();
}

// The same bytes with other meta data; what follows it moves.
AssetBytes with_meta(const AssetBytes& bytes, const std::string& meta_json) {
  const Header before = header_of(bytes);
  Header header = before;
  header.meta_bytes = meta_json.size();
  // The meta data are the last section; relaxation, damage, coupling, leans and shape response lie
  // behind them.
  const std::uint64_t end = before.offset[runtime::kMeta] + runtime::aligned(header.meta_bytes),
                      tail = before.offset[runtime::kMeta] + runtime::aligned(before.meta_bytes);
  runtime::lay_out(header, header.offset);
  header.file_bytes = end + (before.file_bytes - tail);
  AssetBytes out(header.file_bytes);
  std::memcpy(out.data(), bytes.data(), before.offset[runtime::kMeta]);
  std::memcpy(out.data() + header.offset[runtime::kMeta], meta_json.data(), meta_json.size());
  std::memcpy(out.data() + end, bytes.data() + tail, before.file_bytes - tail);
  std::memcpy(out.data(), &header, sizeof header);
  return out;
}

}  // namespace

AssetEdit::AssetEdit(const runtime::AssetView& asset) : bytes_(asset.file_bytes) {
  // The vertices are the first section, and the header lies before them.
  const auto* vertices = reinterpret_cast<const unsigned char*>(asset.vertex);
  std::memcpy(bytes_.data(), vertices - runtime::aligned(sizeof(Header)), bytes_.size());
  runtime::Status status;
  asset_ = runtime::Asset::open_without_replay(bytes_.data(), bytes_.size(), &status);
  if (status != runtime::Status::ok)
    throw Error("asset", runtime::sentence(status), "Export it again.");
  has_turned_.resize(static_cast<std::size_t>(asset_.vertices));
}

float* AssetEdit::section(runtime::Section which) {
  return reinterpret_cast<float*>(bytes_.data() + header_of(bytes_).offset[which]);
}
float* AssetEdit::node(int vertex) {
  return section(runtime::kControls) +
         std::ptrdiff_t{asset_.record[vertex]} * asset_.controls_per_vertex;
}
float* AssetEdit::normal(int vertex) {
  has_turned_[static_cast<std::size_t>(vertex)] = 1;
  return section(runtime::kNormals) + 3 * std::ptrdiff_t{vertex};
}

void AssetEdit::seal() {
  float* depth_m = section(runtime::kMaxDepth);
  for (int t = 0; t < asset_.triangles; ++t) {
    bool turned = false;
    Vec3 x[3], u[3];
    for (int k = 0; k < 3; ++k) {
      turned = turned || has_turned_[static_cast<std::size_t>(asset_.corner(t, k))] != 0;
      x[k] = row(asset_.vertex, asset_.corner(t, k));
      u[k] = row(asset_.normal, asset_.corner(t, k));
    }
    if (turned && asset_.is_solid(t))
      depth_m[t] = static_cast<float>(depth_bound_m(x, u, diagonal_m(asset_)));
  }
  std::fill(has_turned_.begin(), has_turned_.end(), char{0});
  open();
}

void AssetEdit::seal(const std::string& meta_json) {
  bytes_ = with_meta(bytes_, meta_json);
  open();
}

void AssetEdit::open() {
  record_check_forces(bytes_);
  runtime::Status status;
  asset_ = runtime::Asset::open_without_replay(bytes_.data(), bytes_.size(), &status);
}

}  // namespace palpate
