// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The bytes of an asset (.palp), version 1. Little-endian or big-endian as the writer's
// machine; the mark tells. A header, then the sections of `Section` in order, each beginning at the
// next multiple of 64 with zeros between; the whole size is a multiple of 64. Nothing else is
// allowed.

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace palpate {
namespace runtime {

constexpr std::uint32_t kVersion = 1;
constexpr std::uint32_t kEndianMark = 0x01020304;
constexpr std::uint64_t kAlignment = 64;
constexpr std::uint32_t kFlagGuard = 1;  ///< refuse the energy-creating part of slips

// Bounds that keep every size within 64 bits and every walk finite; far above any real body.
constexpr std::int32_t kMaxVertices = 1 << 26;
constexpr std::int32_t kMaxTriangles = 1 << 27;
constexpr std::int32_t kMaxPieces = 256;
constexpr std::int32_t kMaxCheckTicks = 1 << 17;
constexpr std::uint64_t kMaxMetaBytes = 1u << 26;
constexpr int kMaxTreeDepth = 48;
constexpr int kMaxLeafTriangles = 8;

enum Section : int {
  kVertices,  ///< float V x 3 [m], relative to the origin
  kNormals,   ///< float V x 3, inward unit u_l
  kCovered,   ///< uint8 V: 1 where curves answer; elsewhere the controls are zero
  /// float V x (normal, lateral, limit [N]: b_0 = 0, b_j <= b_{j+1}; lean [m]: xyz)
  kControls,
  kTriangles,    ///< int32 F x 3, counter-clockwise from outside
  kNeighbours,   ///< int32 F x 3: across the edge from corner k to k+1; -1 at a border
  kMaxDepth,     ///< float F [m], depth up to which slides are well-conditioned; 0: air
  kTreeNodes,    ///< TreeNode, preorder
  kTreeItems,    ///< int32, triangles of the leaves
  kNormalTable,  ///< double: knots, weights, integrals of a SplineView; likewise the next three
  kLateralTable,
  kLimitTable,
  kLeanTable,   ///< empty where the body does not lean
  kCheckTicks,  ///< CheckTick: a path and the exact forces on the tool it must bring
  kMeta,        ///< JSON for people: error statement, scene hash; the engine does not read it
  kSections
};

/// Bounding box in float, rounded outward. Inner node: the left child is the next node, `at` the
/// right one, items = 0. Leaf: `items` triangles from tree item `at` on.
struct TreeNode {
  float lo[3], hi[3];
  std::int32_t at, items;
};

struct CheckTick {
  double tip_m[3];
  double force_on_tool_N[3];
};

/// The first bytes of an asset. The checksum covers everything after itself.
struct Header {
  char magic[4];  ///< "PALP"
  std::uint32_t endian_mark;
  std::uint64_t checksum;
  std::uint64_t file_bytes;
  std::uint32_t version;
  std::uint32_t flags;
  std::int32_t vertices, triangles, tree_nodes, tree_items;
  std::int32_t check_ticks, check_path_ticks;  ///< a fresh Contact every check_path_ticks ticks
  std::int32_t degree[4], pieces[4];           ///< normal, lateral, limit, lean (0 and 0: none)
  double origin_m[3];                          ///< body coordinates are origin + vertex
  double max_step_m;      ///< a tip that moves farther in one tick has teleported
  double probe_radius_m;  ///< of the probe the curves were measured with; 0 unknown
  std::uint64_t meta_bytes;
  std::uint64_t offset[kSections];
};
static_assert(sizeof(TreeNode) == 32, "tree nodes are packed");
static_assert(sizeof(CheckTick) == 48, "check ticks are packed");
static_assert(sizeof(Header) == 136 + 8 * kSections, "the header is packed");
static_assert(offsetof(Header, file_bytes) == 16, "the checksum covers all from byte 16 on");

inline int curve_size(const Header& h, int curve) noexcept {
  return h.pieces[curve] + h.degree[curve];
}
inline int controls_per_vertex(const Header& h) noexcept {
  return curve_size(h, 0) + curve_size(h, 1) + curve_size(h, 2) + 3 * curve_size(h, 3);
}

inline std::uint64_t table_doubles(const Header& h, int curve) noexcept {
  if (h.pieces[curve] == 0) return 0;
  const std::uint64_t rows = static_cast<std::uint64_t>(h.pieces[curve]) + 1;
  const std::uint64_t order = static_cast<std::uint64_t>(h.degree[curve]) + 1;
  return rows + rows * order * order + rows * static_cast<std::uint64_t>(curve_size(h, curve));
}

/// Bytes of a section without padding. The counts are within the bounds above.
inline std::uint64_t section_bytes(const Header& h, int section) noexcept {
  const auto v = static_cast<std::uint64_t>(h.vertices);
  const auto f = static_cast<std::uint64_t>(h.triangles);
  switch (section) {
    case kVertices:
    case kNormals:
      return 12 * v;
    case kCovered:
      return v;
    case kControls:
      return 4 * v * static_cast<std::uint64_t>(controls_per_vertex(h));
    case kTriangles:
    case kNeighbours:
      return 12 * f;
    case kMaxDepth:
      return 4 * f;
    case kTreeNodes:
      return sizeof(TreeNode) * static_cast<std::uint64_t>(h.tree_nodes);
    case kTreeItems:
      return 4 * static_cast<std::uint64_t>(h.tree_items);
    case kNormalTable:
    case kLateralTable:
    case kLimitTable:
    case kLeanTable:
      return 8 * table_doubles(h, section - kNormalTable);
    case kCheckTicks:
      return sizeof(CheckTick) * static_cast<std::uint64_t>(h.check_ticks);
    default:
      return h.meta_bytes;
  }
}

inline std::uint64_t aligned(std::uint64_t bytes) noexcept {
  return (bytes + (kAlignment - 1)) / kAlignment * kAlignment;
}

/// Whether all counts are possible, so that sizes can be computed from them.
inline bool has_possible_counts(const Header& h) noexcept {
  if (h.vertices < 3 || h.vertices > kMaxVertices) return false;
  if (h.triangles < 1 || h.triangles > kMaxTriangles) return false;
  if (h.tree_nodes < 1 || h.tree_items < 1 || h.tree_items > h.triangles) return false;
  if (h.tree_nodes >= 2 * h.tree_items) return false;
  if (h.check_ticks < 0 || h.check_ticks > kMaxCheckTicks || h.check_path_ticks < 1) return false;
  if (h.meta_bytes > kMaxMetaBytes) return false;
  for (int curve = 0; curve < 4; ++curve) {
    const bool is_absent = curve == 3 && h.degree[curve] == 0 && h.pieces[curve] == 0;
    if (is_absent) continue;
    if (h.degree[curve] < 1 || h.degree[curve] > 4) return false;
    if (h.pieces[curve] < 1 || h.pieces[curve] > kMaxPieces) return false;
  }
  return true;
}

/// Fills `offset` from the counts and returns the whole size: the one layout there is.
inline std::uint64_t lay_out(const Header& h, std::uint64_t offset[kSections]) noexcept {
  std::uint64_t at = aligned(sizeof(Header));
  for (int section = 0; section < kSections; ++section) {
    offset[section] = at;
    at += aligned(section_bytes(h, section));
  }
  return at;
}

/// FNV-1a on 64-bit words of the machine's byte order, each followed by h ^= h >> 32 so that high
/// bits reach low ones (offset basis and prime of FNV-1a 64). Any single changed word is detected;
/// an accident, not an attacker, is what it guards against. bytes is a multiple of 8.
inline std::uint64_t checksum(const void* data, std::uint64_t bytes) noexcept {
  const unsigned char* at = static_cast<const unsigned char*>(data);
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (std::uint64_t i = 0; i + 8 <= bytes; i += 8) {
    std::uint64_t word;
    std::memcpy(&word, at + i, 8);
    hash = (hash ^ word) * 0x100000001b3u;
    hash ^= hash >> 32;
  }
  return hash;
}

/// The checksum of a whole asset of `bytes` bytes: everything after the checksum's own field.
inline std::uint64_t asset_checksum(const void* asset, std::uint64_t bytes) noexcept {
  constexpr std::uint64_t kFrom = offsetof(Header, file_bytes);
  return checksum(static_cast<const unsigned char*>(asset) + kFrom, bytes - kFrom);
}

}  // namespace runtime
}  // namespace palpate
