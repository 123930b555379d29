// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// Checks of an asset's bytes before the engine trusts them. Safe on any bytes: every index is
// tested before it is used, and all work is bounded by the counts.

#include "../base/status.hpp"
#include "../law/compliance.hpp"
#include "shape.hpp"
#include "view.hpp"

namespace palpate::runtime {

constexpr double kUnitTolerance = 1e-4;   ///< of a normal's squared length; float rounding is 2e-7
constexpr double kBasisTolerance = 1e-9;  ///< of basis functions: rounding leaves 1e-14

inline bool is_within(double x, double bound) noexcept { return std::fabs(x) <= bound; }

/// Header, size, alignment, layout and checksum. Fills `header` when ok.
inline Status check_envelope(const void* bytes, std::size_t size, Header& header) noexcept {
  if (bytes == nullptr || size < sizeof(Header)) return Status::bytes_missing;
  if (reinterpret_cast<std::uintptr_t>(bytes) % kByteAlignment != 0)
    return Status::bytes_misaligned;
  std::memcpy(&header, bytes, sizeof(Header));
  if (std::memcmp(header.magic, "PALP", 4) != 0) return Status::not_an_asset;
  if (header.endian_mark != kEndianMark) return Status::other_endianness;
  if (header.version != kVersion || header.law_revision < 0 || header.law_revision > kLawRevision)
    return Status::other_version;
  if (header.file_bytes != size) return Status::size_wrong;
  if (!has_possible_counts(header)) return Status::layout_wrong;
  if ((header.flags & ~(kFlagGuard | kFlagShape | block_flags(Blocks()))) != 0)
    return Status::layout_wrong;
  std::uint64_t offset[kSections];
  const std::uint64_t end = lay_out(header, offset);
  if (end > size) return Status::layout_wrong;
  std::uint64_t shape_bytes = 0;
  if (!measure_shape(bytes, header, end, shape_bytes) || end + shape_bytes != header.file_bytes)
    return Status::layout_wrong;
  for (int section = 0; section < kSections; ++section)
    if (offset[section] != header.offset[section]) return Status::layout_wrong;
  if (header.checksum != asset_checksum(bytes, size)) return Status::checksum_wrong;
  return Status::ok;
}

inline Status check_numbers(const AssetView& view) noexcept {
  for (double x : view.origin_m)
    if (!is_within(x, 1e6)) return Status::numbers_wrong;
  if (!(view.max_step_m > 0 && view.max_step_m <= 1e4)) return Status::numbers_wrong;
  if (!(view.probe_radius_m >= 0 && view.probe_radius_m <= 1e3)) return Status::numbers_wrong;
  if (!(view.first_row_m >= 0 && view.first_row_m <= view.max_fitted_m))
    return Status::numbers_wrong;
  return Status::ok;
}

/// B_g + B_{g+1} + ... on interval i, as a polynomial in the distance from its first knot. A curve
/// whose control values rise is a sum of such tails with weights that are not negative.
inline void tail_of_basis(const SplineView& spline, int i, int g, double* c) noexcept {
  const int order = spline.degree + 1, first = first_control(spline, i);
  for (int m = 0; m < order; ++m) {
    c[m] = g <= first && m == 0 ? 1 : 0;
    for (int k = g - first; g > first && k < order; ++k)
      c[m] += spline.weights[(i * order + k) * order + m];
  }
}

/// Returns true if a polynomial of `order` terms is >= 0 and rises on [0, width]: so do its
/// Bernstein coefficients.
inline bool is_rising(const double* c, int order, double width) noexcept {
  double before = 0;
  for (int j = 0; j < order; ++j) {
    double now = 0, share = 1;  // binomial(j, m) / binomial(degree, m) width^m
    for (int m = 0; m <= j; ++m) {
      now += c[m] * share;
      share *= width * (j - m) / (order - 1 - m > 0 ? order - 1 - m : 1);
    }
    if (!(now >= before - kBasisTolerance)) return false;
    before = now;
  }
  return true;
}

/// On interval i tails rise, to 1 at most, and go on from the interval before; they begin at 0
/// where x is 0. Beyond the last knot they are straight with the slope that they have there, and
/// rise as far again. The weights of both intervals are finite.
inline bool has_rising_tails(const SplineView& spline, int i) noexcept {
  const int order = spline.degree + 1, first = first_control(spline, i);
  const bool is_last = i == spline.pieces;
  const double width = is_last ? spline.knots[i] : spline.knots[i + 1] - spline.knots[i];
  for (int g = first > 0 ? first : 1; g <= first + spline.degree; ++g) {
    double c[kMaxDegree + 1] = {}, before[kMaxDegree + 1] = {};
    tail_of_basis(spline, i, g, c);
    if (!is_rising(c, order, width)) return false;
    if (!is_last && !(basis_value(c, order, width) <= 1 + kBasisTolerance)) return false;
    double from = 0, slope = 0;
    if (i > 0) {
      const double t = spline.knots[i] - spline.knots[i - 1];
      tail_of_basis(spline, i - 1, g, before);
      from = basis_value(before, order, t);
      for (int m = order - 1; m > 0; --m) slope = slope * t + m * before[m];
      if (is_last && !(std::fabs(c[1] - slope) * t <= kBasisTolerance)) return false;
    }
    if (!(std::fabs(c[0] - from) <= kBasisTolerance)) return false;
    for (int m = 2; is_last && m < order; ++m)
      if (c[m] != 0) return false;
  }
  return true;
}

/// Increasing knots from 0, finite tables, basis functions that sum to one on every interval and of
/// which no rising curve (M5) can be made that pulls or falls, and integrals that are theirs (M7).
/// The tables have the sizes that the layout says; nothing else of them is trusted.
inline Status check_spline(const SplineView& spline) noexcept {
  const int order = spline.degree + 1, size = spline.size();
  if (spline.knots[0] != 0) return Status::curves_wrong;
  for (int i = 0; i < spline.pieces; ++i)
    if (!(spline.knots[i + 1] > spline.knots[i] && spline.knots[i + 1] <= kMaxLength_m))
      return Status::curves_wrong;
  double area[kMaxPieces + kMaxDegree] = {};
  for (int i = 0; i <= spline.pieces; ++i) {
    for (int j = 0; j < size; ++j)
      if (!(std::fabs(spline.integrals[i * size + j] - area[j]) <=
            kBasisTolerance * spline.knots[spline.pieces]))
        return Status::curves_wrong;
    const double width =
        i < spline.pieces ? spline.knots[i + 1] - spline.knots[i] : spline.knots[i];
    double power = 1;
    for (int m = 0; m < order; ++m) {
      double sum = 0;
      for (int k = 0; k < order; ++k) {
        const double w = spline.weights[(i * order + k) * order + m];
        if (!is_finite(w)) return Status::curves_wrong;
        sum += w;
      }
      if (!(std::fabs(sum - (m == 0)) * power <= kBasisTolerance)) return Status::curves_wrong;
      power *= width;
    }
    if (!has_rising_tails(spline, i)) return Status::curves_wrong;
    for (int k = 0; i < spline.pieces && k < order; ++k)
      area[i + k] += basis_integral(spline.weights + (i * order + k) * order, order, width) * width;
  }
  return Status::ok;
}

/// Returns true if the press of a vertex can carry its side force: (M22) at the end of the
/// curves, the lateral deflection as long as the depth, with room for what a fit leaves to
/// the guard. Beyond it forces have nothing to do with a body's.
constexpr double kSideSlack = 100;
inline bool is_side_carried(const SplineView& normal, const float* curve, const float* side2,
                            const float* side3) noexcept {
  const double d = normal.knots[normal.pieces], most_N = double(curve[normal.size() - 1]);
  const auto length = [](const float* g) noexcept {
    return std::sqrt(double(g[0]) * g[0] + double(g[1]) * g[1] + double(g[2]) * g[2]);
  };
  return d * d * (2 * length(side2) + 3 * length(side3) * d) <= kSideSlack * most_N;
}

/// Records exist; every part is as its family has it, all zero where a vertex answers with
/// nothing.
inline Status check_controls(const AssetView& view, const Header& h) noexcept {
  for (int v = 0; v < view.vertices; ++v) {
    if (view.covered[v] > kMean || view.record[v] < 0 || view.record[v] >= view.records)
      return Status::controls_wrong;
    const float* control = view.node(v);
    for (int part = 0; part < family_of(h).parts; ++part)
      if (!is_good_part(family_of(h).part[part], control + view.control_offset[part],
                        part_size(h, part), !view.covered[v]))
        return Status::controls_wrong;
    if (h.family == int(Family::rings) &&
        !is_side_carried(view.curves.view[kNormal], control + view.control_offset[kNormal],
                         control + view.control_offset[kSide2],
                         control + view.control_offset[kSide3]))
      return Status::controls_wrong;
    const int sway = sway_part_of(h.family);
    if (sway < 0) continue;
    double c[6];
    for (int i = 0; i < 6; ++i) c[i] = double(control[view.control_offset[sway] + i]);
    if (!is_positive_semidefinite(c)) return Status::controls_wrong;
  }
  return Status::ok;
}

inline Status check_vertices(const AssetView& view) noexcept {
  for (int i = 0; i < 3 * view.vertices; ++i)
    if (!is_within(double(view.vertex[i]), kMaxLength_m)) return Status::vertices_wrong;
  return Status::ok;
}

/// A body's diagonal [m], the longest depth that means anything.
inline double diagonal_of(const AssetView& view) noexcept {
  double squared = 0;
  for (int k = 0; k < 3; ++k) {
    float lo = view.vertex[k], hi = lo;
    for (int v = 1; v < view.vertices; ++v) {
      const float x = view.vertex[3 * v + k];
      lo = x < lo ? x : lo;
      hi = x > hi ? x : hi;
    }
    squared += (double(hi) - double(lo)) * (double(hi) - double(lo));
  }
  return std::sqrt(squared);
}

/// Indices in range and distinct; neighbours share the reversed edge in both directions.
inline Status check_triangles(const AssetView& view) noexcept {
  const double diagonal_m = diagonal_of(view) * (1 + 1e-6);  // the exporter's, to rounding
  for (int t = 0; t < view.triangles; ++t) {
    const int a = view.corner(t, 0), b = view.corner(t, 1), c = view.corner(t, 2);
    for (int k = 0; k < 3; ++k)
      if (view.corner(t, k) < 0 || view.corner(t, k) >= view.vertices)
        return Status::triangles_wrong;
    if (a == b || b == c || c == a) return Status::triangles_wrong;
    if (!(view.max_depth_m[t] >= 0 && double(view.max_depth_m[t]) <= diagonal_m))
      return Status::triangles_wrong;
  }
  for (int t = 0; t < view.triangles; ++t)
    for (int k = 0; k < 3; ++k) {
      const int other = view.neighbour[3 * t + k];
      if (other == -1) continue;
      if (other < 0 || other >= view.triangles || other == t) return Status::neighbours_wrong;
      bool is_matched = false;
      for (int j = 0; j < 3; ++j)
        is_matched = is_matched || (view.corner(other, j) == view.corner(t, (k + 1) % 3) &&
                                    view.corner(other, (j + 1) % 3) == view.corner(t, k) &&
                                    view.neighbour[3 * other + j] == t);
      if (!is_matched) return Status::neighbours_wrong;
    }
  return Status::ok;
}

/// At the corners of solid triangles: unit length, and clearly on the inner side. So no blend of
/// them is zero and every slide direction can be projected.
inline Status check_normals(const AssetView& view) noexcept {
  for (int t = 0; t < view.triangles; ++t) {
    if (!view.is_solid(t)) continue;
    const Vec3d area = view.area_vector(t);
    const double length = std::sqrt(dot(area, area));
    if (!(length > 0)) return Status::triangles_wrong;
    for (int k = 0; k < 3; ++k) {
      const Vec3d u = view.normal_at(view.corner(t, k));
      if (!is_within(dot(u, u) - 1, kUnitTolerance)) return Status::normals_wrong;
      if (!(-dot(u, area) >= kMinFacing * length)) return Status::normals_wrong;
    }
  }
  return Status::ok;
}

inline bool is_inside(const TreeNode& inner, const TreeNode& outer) noexcept {
  for (int k = 0; k < 3; ++k)
    if (!(outer.lo[k] <= inner.lo[k] && inner.lo[k] <= inner.hi[k] && inner.hi[k] <= outer.hi[k]))
      return false;
  return true;
}

inline bool holds_triangle(const TreeNode& node, const AssetView& view, int t) noexcept {
  for (int j = 0; j < 3; ++j)
    for (int k = 0; k < 3; ++k) {
      const float x = view.vertex[3 * view.corner(t, j) + k];
      if (!(node.lo[k] <= x && x <= node.hi[k])) return false;
    }
  return true;
}

/// Leaves name solid triangles that lie inside their boxes, items in order, each used once.
inline bool is_good_leaf(const AssetView& view, const TreeNode& node, int items,
                         int& next_item) noexcept {
  if (node.items > kMaxLeafTriangles || node.at != next_item || node.items > items - next_item)
    return false;
  for (int i = 0; i < node.items; ++i) {
    const int t = view.tree_item[next_item + i];
    if (t < 0 || t >= view.triangles || !view.is_solid(t)) return false;
    if (!holds_triangle(node, view, t)) return false;
  }
  next_item += node.items;
  return true;
}

/// The next number of a sequence. Source: Steele, Lea, Flood, Fast Splittable Pseudorandom Number
/// Generators (2014), SplitMix64.
inline std::uint64_t next_random(std::uint64_t& state) noexcept {
  std::uint64_t z = state += 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

/// Scrambles an index, so that sums of them differ between sets.
inline std::uint64_t scrambled(std::int32_t index) noexcept {
  std::uint64_t state = static_cast<std::uint64_t>(index) * 0x9e3779b97f4a7c15u;
  return next_random(state);
}

/// The items are the solid triangles, each once: nothing that could be touched is missing.
inline bool holds_all_solid(const AssetView& view, int items) noexcept {
  std::uint64_t difference = 0;
  for (int t = 0; t < view.triangles; ++t)
    if (view.is_solid(t)) difference += scrambled(t);
  for (int i = 0; i < items; ++i) difference -= scrambled(view.tree_item[i]);
  return difference == 0;
}

/// A preorder binary tree no deeper than kMaxTreeDepth, a finite root, boxes within their parents'
/// boxes, all nodes, all items and all solid triangles used exactly once.
inline Status check_tree(const AssetView& view, int nodes, int items) noexcept {
  const TreeNode& root = view.tree[0];
  for (int k = 0; k < 3; ++k)  // the swept test takes its allowance from the root's size
    if (!is_within(double(root.lo[k]), 2 * kMaxLength_m) ||
        !is_within(double(root.hi[k]), 2 * kMaxLength_m))
      return Status::tree_wrong;
  struct Range {
    int begin, end, parent, depth;
  };  // a subtree fills nodes begin to end
  Range stack[kMaxTreeDepth + 2];
  int size = 0, next_item = 0;
  stack[size++] = {0, nodes, 0, 0};
  while (size > 0) {
    const Range range = stack[--size];
    const TreeNode& node = view.tree[range.begin];
    if (!is_inside(node, view.tree[range.parent])) return Status::tree_wrong;
    if (node.items != 0) {
      if (node.items < 0 || range.end != range.begin + 1) return Status::tree_wrong;
      if (!is_good_leaf(view, node, items, next_item)) return Status::tree_wrong;
      continue;
    }
    if (range.depth >= kMaxTreeDepth) return Status::tree_wrong;
    if (node.at <= range.begin + 1 || node.at >= range.end) return Status::tree_wrong;
    stack[size++] = {node.at, range.end, range.begin, range.depth + 1};
    stack[size++] = {range.begin + 1, node.at, range.begin, range.depth + 1};
  }
  return next_item == items && holds_all_solid(view, items) ? Status::ok : Status::tree_wrong;
}

/// A Prony series that rings can follow: those of the block and nothing beside them.
inline Status check_block(const AssetView& view, const Header& h,
                          const RelaxationBlock& block) noexcept {
  if (h.family != int(Family::rings) || view.curves.relaxation.branches == 0 ||
      !(block.radius_m >= 0 && block.radius_m <= kMaxNumber))
    return Status::block_wrong;
  for (int k = 0; k < kMaxBranches; ++k) {
    if (k >= block.branches) {
      if (block.share[k] != 0 || block.time_s[k] != 0) return Status::block_wrong;
      continue;
    }
    const double least_s = k > 0 ? block.time_s[k - 1] : 0;
    if (!(block.share[k] > 0 && block.share[k] <= kMaxShare) ||
        !(block.time_s[k] >= kMinRelaxation_s && block.time_s[k] <= kMaxRelaxation_s) ||
        !(block.time_s[k] > least_s))
      return Status::block_wrong;
  }
  return Status::ok;
}

/// Numbers that damage can follow: those of the block and nothing beside them.
inline Status check_block(const AssetView&, const Header&, const DamageBlock& block) noexcept {
  const auto is_within = [](double x, double least, double most) noexcept {
    return x >= least && x <= most;
  };
  const DamageView& damage = block.damage;
  bool is_good = is_within(damage.r, kMinDamage, kMaxDamage) &&
                 is_within(damage.scale, 0, kMaxDamage) && is_within(damage.beta, 0, kMaxDamage) &&
                 damage.scale + damage.beta > 0 && is_within(damage.reach_m, 0, kMaxLength_m);
  for (const double reserved : block.reserved) is_good = is_good && reserved == 0;
  return is_good ? Status::ok : Status::block_wrong;
}

/// Numbers that coupling can follow, on rings.
inline Status check_block(const AssetView&, const Header& h, const CouplingBlock& block) noexcept {
  for (const double reserved : block.reserved)
    if (reserved != 0) return Status::block_wrong;
  const bool is_good = h.family == static_cast<int>(Family::rings) && is_possible(block.coupling);
  return is_good ? Status::ok : Status::block_wrong;
}

/// Triangles that exist, places on them, and offsets of a body's size.
inline Status check_visual(const AssetView& view) noexcept {
  for (int i = 0; i < view.visual.vertices; ++i) {
    const VisualVertex& hung = view.visual.vertex[i];
    const double b = double(hung.weight[0]), c = double(hung.weight[1]);
    bool is_good = hung.triangle >= 0 && hung.triangle < view.triangles && b >= 0 && c >= 0 &&
                   b + c <= 1 + 1e-6;  // rounding of floats
    for (const float offset_m : hung.offset_m)
      is_good = is_good && is_within(double(offset_m), kMaxLength_m);
    if (!is_good) return Status::block_wrong;
  }
  return Status::ok;
}

/// Checks all blocks of an asset whose sections are checked.
template <class... Each>
Status check_blocks(const AssetView& view, const Header& h, const void* bytes,
                    AssetBlocks<Each...>) noexcept {
  Status status = Status::ok;
  const auto check = [&](const auto* block) noexcept {
    if (status == Status::ok && block != nullptr) status = check_block(view, h, *block);
  };
  (check(block_of<Each>(bytes, h)), ...);
  return status;
}

/// Everything about the sections of an asset whose envelope is good.
inline Status check_sections(const AssetView& view, const Header& header,
                             const void* bytes) noexcept {
  Status status = check_numbers(view);
  for (const SplineView& spline : view.curves.view)
    if (status == Status::ok && spline.pieces > 0) status = check_spline(spline);
  if (status == Status::ok) status = check_controls(view, header);
  if (status == Status::ok) status = check_vertices(view);
  if (status == Status::ok) status = check_triangles(view);
  if (status == Status::ok) status = check_normals(view);
  if (status == Status::ok) status = check_tree(view, header.tree_nodes, header.tree_items);
  if (status == Status::ok) status = check_blocks(view, header, bytes, Blocks());
  if (status == Status::ok) status = check_visual(view);
  if (status == Status::ok && view.shape.points > 0) status = check_shape(view);
  return status;
}

}  // namespace palpate::runtime
