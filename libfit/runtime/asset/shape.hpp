// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The shape response of an asset that has one: its bytes behind the last section, a view of them,
// and what is checked before they are trusted. deform.hpp evaluates it.

#include "../base/status.hpp"
#include "view.hpp"

namespace palpate::runtime {

constexpr int kMaxShapeIntervals = 32, kMaxShapeModes = 32;
constexpr std::int32_t kMaxShapePoints = 1 << 20;
constexpr double kMaxShapeNumber = 1e6;  ///< of any number of the response
/// Near functions of a test point, each with kShapeDepths coefficients per spline: the dent along
/// u, loading and unloading. Of the body: how the surface follows a tool sideways.
constexpr int kShapePressed = 2, kShapeDepths = 2, kShapeDragged = 3;

/// Size of a point's record: near functions, then each mode's displacement by a force along x, y
/// and z [m/N]. And the body.
inline int shape_numbers(int intervals, int modes) noexcept {
  return kShapePressed * kShapeDepths * intervals + 3 * modes;
}
inline int shape_drag_numbers(int intervals) noexcept { return kShapeDragged * intervals; }

enum ShapePart : int {
  kShapeBlendPoint,   ///< int32 R x 3: test points whose numbers the vertex of a record blends
  kShapeBlendWeight,  ///< float R x 3, sum 1; 0 where not measured
  kShapePoint,        ///< float P x shape_numbers
  kShapeDrag,         ///< float shape_drag_numbers
  kShapeMode,         ///< float V x modes x 3: fields of the whole body
  kShapeParts
};

inline std::uint64_t shape_part_bytes(const ShapeHeader& s, const Header& asset,
                                      int part) noexcept {
  const auto v = static_cast<std::uint64_t>(asset.vertices);
  switch (part) {
    case kShapeBlendPoint:
    case kShapeBlendWeight:
      return 12 * static_cast<std::uint64_t>(asset.records);
    case kShapePoint:
      return 4 * static_cast<std::uint64_t>(s.points) *
             static_cast<std::uint64_t>(shape_numbers(s.intervals, s.modes));
    case kShapeDrag:
      return 4 * static_cast<std::uint64_t>(shape_drag_numbers(s.intervals));
    default:
      return 12 * v * static_cast<std::uint64_t>(s.modes);
  }
}

inline bool has_possible_shape(const ShapeHeader& s) noexcept {
  return s.points >= 1 && s.points <= kMaxShapePoints && s.intervals >= 1 &&
         s.intervals <= kMaxShapeIntervals && s.modes >= 0 && s.modes <= kMaxShapeModes &&
         s.radius_power >= 0 && s.radius_power <= 2 && s.reserved[0] == 0 && s.reserved[1] == 0 &&
         s.reserved[2] == 0 && s.reserved[3] == 0;
}

/// Fills where each part begins from the beginning of the header, and returns the whole size.
inline std::uint64_t lay_out_shape(const ShapeHeader& s, const Header& asset,
                                   std::uint64_t offset[kShapeParts]) noexcept {
  std::uint64_t at = aligned(sizeof(ShapeHeader));
  for (int part = 0; part < kShapeParts; ++part) {
    offset[part] = at;
    at += aligned(shape_part_bytes(s, asset, part));
  }
  return at;
}

/// Bytes of the shape response of an asset whose sections end at `sections_end`; 0 without one.
/// False where there is no room for what its header says. Safe on any bytes [header.file_bytes].
inline bool measure_shape(const void* bytes, const Header& header, std::uint64_t sections_end,
                          std::uint64_t& shape_bytes) noexcept {
  shape_bytes = 0;
  if ((header.flags & kFlagShape) == 0) return true;
  if (header.file_bytes < sections_end ||
      header.file_bytes - sections_end < aligned(sizeof(ShapeHeader)))
    return false;
  ShapeHeader shape;
  std::memcpy(&shape, static_cast<const unsigned char*>(bytes) + sections_end, sizeof shape);
  if (!has_possible_shape(shape)) return false;
  std::uint64_t offset[kShapeParts];
  shape_bytes = lay_out_shape(shape, header, offset);
  return true;
}

/// Points the view at a shape response at `bytes` whose header was measured.
inline ShapeView shape_view_of(const void* bytes, const Header& asset) noexcept {
  ShapeHeader header;
  std::memcpy(&header, bytes, sizeof header);
  std::uint64_t offset[kShapeParts];
  lay_out_shape(header, asset, offset);
  const auto* base = static_cast<const unsigned char*>(bytes);
  ShapeView view{};
  static_cast<ShapeHeader&>(view) = header;
  view.blend_point = reinterpret_cast<const std::int32_t*>(base + offset[kShapeBlendPoint]);
  view.blend_weight = reinterpret_cast<const float*>(base + offset[kShapeBlendWeight]);
  view.point = reinterpret_cast<const float*>(base + offset[kShapePoint]);
  view.drag = reinterpret_cast<const float*>(base + offset[kShapeDrag]);
  view.mode = reinterpret_cast<const float*>(base + offset[kShapeMode]);
  return view;
}

/// Lengths, indices, weights and numbers of a shape response, and the normals that it reads.
inline Status check_shape(const AssetView& view) noexcept {
  constexpr double kSumTolerance = 1e-5;
  const ShapeView& shape = view.shape;
  if (!(shape.depth_m > 0 && shape.depth_m <= kMaxLength_m)) return Status::shape_wrong;
  if (!(shape.radius_m > 0 && shape.radius_m <= kMaxLength_m)) return Status::shape_wrong;
  const auto are_good = [](const float* x, std::uint64_t count) noexcept {
    for (std::uint64_t i = 0; i < count; ++i)
      if (!(std::fabs(double(x[i])) <= kMaxShapeNumber)) return false;
    return true;
  };
  const auto numbers = static_cast<std::uint64_t>(shape_numbers(shape.intervals, shape.modes));
  const auto drag = static_cast<std::uint64_t>(shape_drag_numbers(shape.intervals));
  const auto modes = 3 * static_cast<std::uint64_t>(shape.modes);
  if (!are_good(shape.point, numbers * static_cast<std::uint64_t>(shape.points)) ||
      !are_good(shape.drag, drag) ||
      !are_good(shape.mode, modes * static_cast<std::uint64_t>(view.vertices)))
    return Status::shape_wrong;
  for (int v = 0; v < view.vertices; ++v) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
      const std::int32_t at = 3 * view.record[v] + k, point = shape.blend_point[at];
      const double weight = double(shape.blend_weight[at]);
      if (point < 0 || point >= shape.points || !(weight >= 0 && weight <= 1))
        return Status::shape_wrong;
      sum += weight;
      if (!(std::fabs(double(view.normal[3 * v + k])) <= 2)) return Status::shape_wrong;
    }
    if (!(std::fabs(sum - (view.covered[v] == kMeasured ? 1 : 0)) <= kSumTolerance))
      return Status::shape_wrong;
  }
  return Status::ok;
}

}  // namespace palpate::runtime
