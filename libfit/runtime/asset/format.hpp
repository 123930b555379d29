// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The bytes of an asset (.palp), version 1. Little-endian or big-endian as the writer's
// machine; the mark shows which. A header, then the sections of `Section` in order, each beginning
// at the next multiple of 64 with zeros between, then likewise the VisualVertex of a mesh that the
// asset moves, the blocks of `Blocks` that the flags name, and with kFlagShape a shape response
// (shape.hpp); the whole size is a multiple of 64. Nothing else is allowed.

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "../law/coupling.hpp"
#include "../law/families.hpp"
#include "../law/softening.hpp"

namespace palpate::runtime {

constexpr std::uint32_t kVersion = 1;
/// Raised when the engine computes other bits from the same bytes. The check path of an older
/// revision need not be met bit for bit.
constexpr std::int32_t kLawRevision = 4;
constexpr std::uint32_t kEndianMark = 0x01020304;
constexpr std::uint64_t kAlignment = 64;
constexpr std::uint64_t kByteAlignment = 8;  ///< of the bytes in memory: that of any malloc
/// Flags of the header; blocks (RelaxationBlock and those below it) have the further ones.
enum HeaderFlag : std::uint32_t {
  kFlagGuard = 1,  ///< refuse the energy-creating part of slips
  kFlagShape = 2   ///< a shape response follows the sections
};

/// Source of a vertex's curves.
enum CurveSource : std::uint8_t {
  kNoCurves,  ///< its controls are zero
  kMeasured,  ///< its own curves
  kMean       ///< the mean of the body's, where no test point answers
};

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
  kCovered,   ///< uint8 V: kMeasured, kMean or 0
  kRecords,   ///< int32 V: row of kControls; vertices that answer alike share one
  /// float R x the numbers of the family's parts in turn, control value by control value: bounds
  /// and order as the parts say (law/curve_views.hpp)
  kControls,
  kTriangles,   ///< int32 F x 3, counter-clockwise from outside
  kNeighbours,  ///< int32 F x 3: across the edge from corner k to k+1; -1 at a border
  kMaxDepth,    ///< float F [m], depth up to which slides are well-conditioned; 0: air
  kTreeNodes,   ///< TreeNode, preorder
  kTreeItems,   ///< int32, triangles of the leaves
  /// double: knots, weights, integrals of a SplineView; likewise of each part, empty where it is no
  /// curve
  kPartTable,
  kLastPartTable = kPartTable + kMaxParts - 1,
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

/// A vertex of a mesh that is drawn in place of the surface: where it hangs on a triangle.
struct VisualVertex {
  std::int32_t triangle;
  float weight[2];    ///< area coordinates of corners 1 and 2 at the nearest place
  float offset_m[3];  ///< from there, along TriangleAxes (contact/visual.hpp)
};

// Blocks of what only some bodies have; numbers that are not used are 0.

/// The Prony series of a body that relaxes.
struct RelaxationBlock {
  static constexpr std::uint32_t kFlag = 4;
  std::int64_t branches;                             ///< 1 to kMaxBranches
  double share[kMaxBranches], time_s[kMaxBranches];  ///< 0 of branches that are not
  double radius_m;                                   ///< of the ball; 0: slides renew no material
};
/// Softening of the body (law/softening.hpp).
struct DamageBlock {
  static constexpr std::uint32_t kFlag = 8;
  DamageView damage;
  double reserved[4];
};
/// Compliance between contacts on the body (law/coupling.hpp).
struct CouplingBlock {
  static constexpr std::uint32_t kFlag = 16;
  CouplingView coupling;
  double reserved[3];
};

template <class... Each>
struct AssetBlocks {};
/// In the order in which they lie in the file.
using Blocks = AssetBlocks<RelaxationBlock, DamageBlock, CouplingBlock>;

constexpr double kCheckTick_s = 1e-3;  ///< between two ticks of the check path

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
  std::int32_t family, law_revision;           ///< row of law/families.hpp; kLawRevision
  std::int32_t records, visual_vertices;       ///< R: rows of kControls; VisualVertex, 0 none
  std::int32_t degree[kMaxParts], pieces[kMaxParts];  ///< of each part's basis; 0 where none is
  double origin_m[3];                                 ///< body coordinates are origin + vertex
  double max_step_m;      ///< a tip that moves farther in one tick has teleported
  double probe_radius_m;  ///< of the ball that pressed; 0 where another tool did, or unknown
  double first_row_m;     ///< below it no press has a row; 0 unknown
  std::uint64_t meta_bytes;
  std::uint64_t offset[kSections];
};
static_assert(sizeof(TreeNode) == 32, "tree nodes are packed");
static_assert(sizeof(CheckTick) == 48, "check ticks are packed");
static_assert(sizeof(VisualVertex) == 24, "visual vertices are packed");
static_assert(sizeof(RelaxationBlock) == 64, "the block of relaxation is packed");
static_assert(sizeof(DamageBlock) == 64, "the block of damage is packed");
static_assert(sizeof(CouplingBlock) == 128, "the block of coupling is packed");
static_assert(sizeof(Header) == 208 + 8 * kSections, "the header is packed");
static_assert(offsetof(Header, file_bytes) == 16, "the checksum covers all from byte 16 on");

/// The parts of the asset's family; the number is possible.
inline const FamilyRow& family_of(const Header& h) noexcept {
  return row_of(static_cast<Family>(h.family));
}
/// Control values of a part, each of `width` numbers.
inline int part_size(const Header& h, int part) noexcept {
  const int count = family_of(h).part[part].count;
  return count > 0 ? count : h.pieces[part] + h.degree[part];
}
inline int controls_per_vertex(const Header& h) noexcept {
  int sum = 0;
  for (int part = 0; part < family_of(h).parts; ++part)
    sum += family_of(h).part[part].width * part_size(h, part);
  return sum;
}

inline std::uint64_t table_doubles(const Header& h, int part) noexcept {
  if (h.pieces[part] == 0) return 0;
  const std::uint64_t rows = h.pieces[part] + 1, order = h.degree[part] + 1;
  return rows + rows * order * order + rows * part_size(h, part);
}

/// Bytes of a section without padding. The counts are within the bounds above.
inline std::uint64_t section_bytes(const Header& h, int section) noexcept {
  const std::uint64_t v = h.vertices, f = h.triangles, r = h.records;
  switch (section) {
    case kVertices:
    case kNormals:
      return 12 * v;
    case kCovered:
      return v;
    case kRecords:
      return 4 * v;
    case kControls:
      return 4 * r * controls_per_vertex(h);
    case kTriangles:
    case kNeighbours:
      return 12 * f;
    case kMaxDepth:
      return 4 * f;
    case kTreeNodes:
      return sizeof(TreeNode) * h.tree_nodes;
    case kTreeItems:
      return std::uint64_t{4} * h.tree_items;
    case kCheckTicks:
      return sizeof(CheckTick) * h.check_ticks;
    case kMeta:
      return h.meta_bytes;
    default:
      return 8 * table_doubles(h, section - kPartTable);
  }
}

inline std::uint64_t aligned(std::uint64_t bytes) noexcept {
  return (bytes + (kAlignment - 1)) / kAlignment * kAlignment;
}

inline std::uint64_t visual_bytes(const Header& h) noexcept {
  return aligned(sizeof(VisualVertex) * h.visual_vertices);
}
/// Offset of the visual vertices, of a header whose offsets are filled.
inline std::uint64_t visual_offset(const Header& h) noexcept {
  return h.offset[kMeta] + aligned(h.meta_bytes);
}

/// Bytes of the blocks that an asset with these flags has, up to the one of that flag; of all where
/// there is none.
template <class... Each>
constexpr std::uint64_t block_bytes(std::uint32_t flags, std::uint32_t until,
                                    AssetBlocks<Each...>) noexcept {
  std::uint64_t sum = 0;
  bool is_past = false;
  ((is_past = is_past || Each::kFlag == until,
    sum += !is_past && (flags & Each::kFlag) != 0 ? sizeof(Each) : 0),
   ...);
  return sum;
}
template <class... Each>
constexpr std::uint32_t block_flags(AssetBlocks<Each...>) noexcept {
  static_assert(((sizeof(Each) % kAlignment == 0) && ...), "blocks are packed");
  return (Each::kFlag | ...);
}

/// Returns true if all counts are possible, so that sizes can be computed from them.
inline bool has_possible_counts(const Header& h) noexcept {
  if (h.vertices < 3 || h.vertices > kMaxVertices) return false;
  if (h.records < 1 || h.records > h.vertices) return false;
  if (h.visual_vertices < 0 || h.visual_vertices > kMaxVertices) return false;
  if (h.triangles < 1 || h.triangles > kMaxTriangles) return false;
  if (h.tree_nodes < 1 || h.tree_items < 1 || h.tree_items > h.triangles) return false;
  if (h.tree_nodes >= 2 * h.tree_items) return false;
  if (h.check_ticks < 1 || h.check_ticks > kMaxCheckTicks || h.check_path_ticks < 1) return false;
  if (h.meta_bytes > kMaxMetaBytes) return false;
  if (h.family < 0 || h.family >= kFamilies) return false;
  for (int part = 0; part < kMaxParts; ++part) {
    const bool has_basis = part < family_of(h).parts && family_of(h).part[part].is_curve();
    if (h.degree[part] < (has_basis ? 1 : 0) || h.degree[part] > (has_basis ? kMaxDegree : 0))
      return false;
    if (h.pieces[part] < (has_basis ? 1 : 0) || h.pieces[part] > (has_basis ? kMaxPieces : 0))
      return false;
  }
  return true;
}

/// Fills `offset` from the counts and returns where the blocks end: the one layout there is, but
/// for the shape response behind them.
inline std::uint64_t lay_out(const Header& h, std::uint64_t offset[kSections]) noexcept {
  std::uint64_t at = aligned(sizeof(Header));
  for (int section = 0; section < kSections; ++section) {
    offset[section] = at;
    at += aligned(section_bytes(h, section));
  }
  return at + visual_bytes(h) + block_bytes(h.flags, 0, Blocks());
}

/// A block of whole bytes of an asset; null where it has none.
template <class Block>
const Block* block_of(const void* bytes, const Header& h) noexcept {
  if ((h.flags & Block::kFlag) == 0) return nullptr;
  std::uint64_t offset[kSections];
  const std::uint64_t begin = lay_out(h, offset) - block_bytes(h.flags, 0, Blocks());
  return reinterpret_cast<const Block*>(static_cast<const unsigned char*>(bytes) + begin +
                                        block_bytes(h.flags, Block::kFlag, Blocks()));
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

}  // namespace palpate::runtime
