// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// Opening an asset: bytes that a file map, a pack or a program's own data section holds.

#include "asset/check.hpp"
#include "series/tick.hpp"

namespace palpate::runtime {

/// Runs the path's ticks and calls back with the tick's index and its force. Fresh contact at every
/// multiple of check_path_ticks.
template <class Callback>
bool replay_check_path(const AssetView& view, Callback callback) noexcept {
  Contact contact;
  for (int i = 0; i < view.check.ticks; ++i) {
    if (i % view.check.path_ticks == 0) contact = Contact();
    Output out;
    touch(view, contact, view.check.tick[i].tip_m, out, nullptr, kCheckTick_s);
    if (!callback(i, out)) return false;
  }
  return true;
}

constexpr double kRevisionTolerance = 1e-6;  ///< of the peak force, for an older law revision

/// Returns true if the engine brings the forces of the check path: bit for bit, or within
/// kRevisionTolerance where an older revision of the law recorded them.
inline bool meets_check_path(const AssetView& view) noexcept {
  double peak = 0;
  for (int i = 0; i < view.check.ticks; ++i)
    for (double f : view.check.tick[i].force_on_tool_N)
      peak = std::fabs(f) > peak ? std::fabs(f) : peak;
  const double most = view.check.law_revision == kLawRevision ? -1 : kRevisionTolerance * peak;
  return replay_check_path(view, [&](int i, const Output& tick) noexcept {
    const double* expected = view.check.tick[i].force_on_tool_N;
    if (std::memcmp(tick.force_on_tool_N, expected, sizeof tick.force_on_tool_N) == 0) return true;
    for (int k = 0; k < 3; ++k)
      if (!(std::fabs(tick.force_on_tool_N[k] - expected[k]) <= most)) return false;
    return true;
  });
}

/// An asset whose bytes have all been checked, for touch().
class Asset : public AssetView {
 public:
  Asset() noexcept = default;

  /// Opens the asset in `bytes` [size], 8-byte aligned; the bytes must outlive it unchanged.
  /// Trusts nothing: sizes, offsets, checksum, indices, finite numbers, increasing controls, unit
  /// normals, tree, and the replay of the check path bit for bit. Safe on hostile bytes. On any
  /// fault *status says which and the asset is empty (is_open() is false). Call it outside the
  /// real-time thread: it reads every byte once or twice (about 1 ms per 2 MB).
  static Asset open(const void* bytes, std::size_t size, Status* status) noexcept;

  /// Opens without replaying the check path: for the exporter, which records its forces so.
  static Asset open_without_replay(const void* bytes, std::size_t size, Status* status) noexcept;

  bool is_open() const noexcept { return triangles > 0; }

 private:
  static double skin_of(const AssetView& view) noexcept {
    const TreeNode& root = view.tree[0];
    double squared = 0;
    for (int k = 0; k < 3; ++k) {
      const double side = double(root.hi[k]) - double(root.lo[k]);
      squared += side * side;
    }
    return 1e-9 * std::sqrt(squared);
  }
};

#if PALPATE_HAS_BODIES
PALPATE_ONCE Asset Asset::open(const void* bytes, std::size_t size, Status* status) noexcept {
  Status unused;
  Status& out = status != nullptr ? *status : unused;
  const Asset asset = open_without_replay(bytes, size, &out);
  if (out != Status::ok) return Asset();
  const bool is_same = meets_check_path(asset);
  if (!is_same) out = Status::replay_differs;
  return is_same ? asset : Asset();
}

PALPATE_ONCE Asset Asset::open_without_replay(const void* bytes, std::size_t size,
                                              Status* status) noexcept {
  Header header;
  Asset asset;
  *status = check_envelope(bytes, size, header);
  if (*status != Status::ok) return Asset();
  static_cast<AssetView&>(asset) = view_of(bytes, header);
  std::uint64_t offset[kSections];
  const std::uint64_t end = lay_out(header, offset);
  if (end < header.file_bytes)
    asset.shape = shape_view_of(static_cast<const unsigned char*>(bytes) + end, header);
  *status = check_sections(asset, header, bytes);
  if (*status != Status::ok) return Asset();
  asset.skin_m = skin_of(asset);
  asset.sways = any_sway(asset);
  return asset;
}
#endif

}  // namespace palpate::runtime
