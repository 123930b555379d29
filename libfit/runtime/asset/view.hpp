// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// An opened asset: typed pointers into the caller's bytes, which must outlive it unchanged.

#include <cstdint>

#include "format.hpp"

namespace palpate::runtime {

/// Counts and lengths; 64 bytes. Behind it, each at the next multiple of 64 with zeros between:
/// the parts of ShapePart (shape.hpp).
struct ShapeHeader {
  std::int32_t points, intervals, modes;
  std::int32_t radius_power;  ///< a = radius_m (d / depth_m)^(radius_power / 2): 0, 1, 2
  double depth_m, radius_m;
  double reserved[4];  ///< 0
};
static_assert(sizeof(ShapeHeader) == 64, "the header of the shape response is packed");

/// Displacement of the surface under a tool (deform.hpp); no points: the asset has no shape
/// response.
struct ShapeView : ShapeHeader {
  const std::int32_t* blend_point = nullptr;  ///< three of each record
  const float* blend_weight = nullptr;
  const float* point = nullptr;
  const float* drag = nullptr;
  const float* mode = nullptr;
};

struct DamagedVertex;

/// The bytes that hold an asset.
struct AssetFileView {
  std::uint32_t version = 0;
  std::uint64_t bytes = 0, meta_bytes = 0;
  const char* meta = nullptr;  ///< JSON, not terminated
};

/// Ticks that the engine reproduces when it opens an asset. path_ticks: of each contact.
struct CheckPathView {
  const CheckTick* tick = nullptr;
  int ticks = 0, path_ticks = 1;
  int law_revision = 0;  ///< of the engine that recorded them
};

/// The surface at rest with its bounding tree: all that collision detection and slides read.
struct SurfaceView {
  int vertices = 0, triangles = 0;
  const float* vertex = nullptr;
  const float* normal = nullptr;
  const std::int32_t* triangle = nullptr;
  const std::int32_t* neighbour = nullptr;
  const float* max_depth_m = nullptr;
  const TreeNode* tree = nullptr;
  const std::int32_t* tree_item = nullptr;
  double origin_m[3] = {0, 0, 0};
  double skin_m = 0;  ///< rounding allowance of the swept test: 1e-9 of the body's diagonal

  Vec3d vertex_at(int v) const noexcept {
    return {double(vertex[3 * v]), double(vertex[3 * v + 1]), double(vertex[3 * v + 2])};
  }
  Vec3d normal_at(int v) const noexcept {
    return {double(normal[3 * v]), double(normal[3 * v + 1]), double(normal[3 * v + 2])};
  }
  /// Corner k (any of 0, 1, 2) of triangle t.
  int corner(int t, int k) const noexcept { return triangle[3 * t + k]; }
  /// A triangle that can be touched and slid over: the others are air.
  bool is_solid(int t) const noexcept { return max_depth_m[t] > 0; }
  /// Twice the area times the OUTWARD normal of triangle t.
  Vec3d area_vector(int t) const noexcept {
    const Vec3d a = vertex_at(corner(t, 0));
    return cross(vertex_at(corner(t, 1)) - a, vertex_at(corner(t, 2)) - a);
  }
};

/// The control values of the law at each vertex.
struct NodeTable {
  int records = 0;  ///< rows of controls
  int controls_per_vertex = 0;
  int control_offset[kMaxParts] = {};  ///< begin of each part in a vertex's controls
  const std::uint8_t* covered = nullptr;
  const std::int32_t* record = nullptr;  ///< row of controls of each vertex
  const float* control = nullptr;

  const float* node(int v) const noexcept {
    return control + std::ptrdiff_t{record[v]} * controls_per_vertex;
  }
};

/// A mesh that the surface moves (contact/visual.hpp).
struct VisualView {
  int vertices = 0;
  const VisualVertex* vertex = nullptr;
};

/// Everything that a tick reads. Immutable; any number of threads and tools may share it.
/// Asset::open makes it, after a check of every index and number.
struct AssetView : SurfaceView, NodeTable {
  AssetFileView file;
  CheckPathView check;
  CurveViews curves;
  std::uint64_t checksum = 0;
  double max_step_m = 0;
  double probe_radius_m = 0;
  double first_row_m = 0;   ///< depth of the first row of presses; 0 unknown
  double max_fitted_m = 0;  ///< deepest that the curves were measured
  bool is_rough = false;    ///< another indenter's, which not all of the law is known to follow
  bool has_guard = true;
  bool sways = false;  ///< some vertex has a compliance of the body
  ShapeView shape = {};
  VisualView visual = {};
  const CouplingView* coupling = nullptr;  ///< null: contacts do not move each other
  DamageView damage;                       ///< softening of a body of this asset (contact/body.hpp)
  DamagedVertex* body = nullptr;           ///< set by with_body(); null: it does not soften
};

/// Has no branches if the block has not 1 to kMaxBranches.
inline RelaxationView relaxation_of(const RelaxationBlock& block) noexcept {
  RelaxationView out;
  if (!(block.branches >= 1 && block.branches <= kMaxBranches)) return out;
  out.branches = static_cast<int>(block.branches);
  out.radius_m = block.radius_m;
  for (int k = 0; k < out.branches; ++k) {
    out.share[k] = block.share[k];
    out.time_s[k] = block.time_s[k];
    out.fast += block.share[k];
  }
  return out;
}

/// Points the view at the sections of bytes whose header has the one possible layout.
inline AssetView view_of(const void* bytes, const Header& h) noexcept {
  const auto* base = static_cast<const unsigned char*>(bytes);
  const auto at = [&](int section) { return base + h.offset[section]; };
  AssetView view;
  view.file.version = h.version;
  view.check.law_revision = h.law_revision;
  view.vertices = h.vertices;
  view.triangles = h.triangles;
  view.records = h.records;
  view.controls_per_vertex = controls_per_vertex(h);
  view.vertex = reinterpret_cast<const float*>(at(kVertices));
  view.normal = reinterpret_cast<const float*>(at(kNormals));
  view.covered = at(kCovered);
  view.record = reinterpret_cast<const std::int32_t*>(at(kRecords));
  view.control = reinterpret_cast<const float*>(at(kControls));
  view.triangle = reinterpret_cast<const std::int32_t*>(at(kTriangles));
  view.neighbour = reinterpret_cast<const std::int32_t*>(at(kNeighbours));
  view.max_depth_m = reinterpret_cast<const float*>(at(kMaxDepth));
  view.tree = reinterpret_cast<const TreeNode*>(at(kTreeNodes));
  view.tree_item = reinterpret_cast<const std::int32_t*>(at(kTreeItems));
  view.curves.family = h.family;
  for (int part = 0, offset = 0; part < family_of(h).parts; ++part) {
    SplineView& spline = view.curves.view[part];
    const int rows = h.pieces[part] + 1, order = h.degree[part] + 1;
    view.control_offset[part] = offset;
    offset += family_of(h).part[part].width * part_size(h, part);
    if (h.pieces[part] == 0) continue;  // numbers
    spline.degree = h.degree[part];
    spline.pieces = h.pieces[part];
    spline.knots = reinterpret_cast<const double*>(at(kPartTable + part));
    spline.weights = spline.knots + rows;
    spline.integrals = spline.weights + rows * order * order;
  }
  prepare(view.curves);
  if (const auto* block = block_of<RelaxationBlock>(bytes, h))
    view.curves.relaxation = relaxation_of(*block);
  if (const auto* block = block_of<DamageBlock>(bytes, h)) view.damage = block->damage;
  if (const auto* block = block_of<CouplingBlock>(bytes, h)) view.coupling = &block->coupling;
  view.visual.vertices = h.visual_vertices;
  view.visual.vertex = reinterpret_cast<const VisualVertex*>(base + visual_offset(h));
  view.check.tick = reinterpret_cast<const CheckTick*>(at(kCheckTicks));
  view.check.ticks = h.check_ticks;
  view.check.path_ticks = h.check_path_ticks;
  view.file.meta = reinterpret_cast<const char*>(at(kMeta));
  view.file.meta_bytes = h.meta_bytes;
  view.file.bytes = h.file_bytes;
  view.checksum = h.checksum;
  view.max_fitted_m = view.curves.view[kNormal].knots[view.curves.view[kNormal].pieces];
  for (int k = 0; k < 3; ++k) view.origin_m[k] = h.origin_m[k];
  view.max_step_m = h.max_step_m;
  view.probe_radius_m = h.probe_radius_m;
  view.first_row_m = h.first_row_m;
  view.has_guard = (h.flags & kFlagGuard) != 0;
  return view;
}

/// Stiffness of a contact at the end of its normal curve, along the normal and across it [N/m], at
/// a place of a triangle.
struct ContactStiffness {
  double along_N_m = 0, across_N_m = 0;
};
inline ContactStiffness stiffness_at_end(const AssetView& view, int triangle,
                                         const double weight[3]) noexcept {
  const SplineView& spline = view.curves.view[kNormal];
  const double end = spline.knots[spline.pieces];
  const auto at_end = spline_weights(spline, find_piece(spline, end), end);
  double along = 0, lambda = 0;
  for (int k = 0; k < 3; ++k) {
    const float* node = view.node(view.corner(triangle, k));
    along +=
        weight[k] * dot(spline, at_end.slope, node + view.control_offset[kNormal], at_end.first);
    lambda += weight[k] * double(node[view.control_offset[kLambda]]);
  }
  return {along, along * lambda};
}

/// s of (M62): the share of the body's coupling that a contact there has; below 1 where it is so
/// stiff that the energy of several would not stay convex. view: that of the tool.
inline double coupling_share(const AssetView& view, const CouplingView& coupling, int triangle,
                             const double weight[3]) noexcept {
  const ContactStiffness k = stiffness_at_end(view, triangle, weight);
  const double excess = coupling_excess(coupling, k.along_N_m, k.across_N_m);
  return excess > 1 ? 1 / std::sqrt(excess) : 1;
}

}  // namespace palpate::runtime
