// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

#include "rounding.hpp"

namespace palpate::runtime {

/// Result of opening an asset, and of every tick. Numbers below 100 are those of palpate.h.
enum class Status {
  ok = 0,
  // ticks: the force is zero whenever one of these comes back
  tip_not_finite = 4,
  tip_teleported,
  contact_foreign,
  force_not_finite,
  pose_wrong,
  time_step_wrong,
  tool_wrong,
  no_shape,  // displacements are zero
  radius_wrong = 100,
  // opening an asset
  bytes_missing = 20,
  bytes_misaligned,
  not_an_asset,
  other_endianness,
  other_version,
  size_wrong,
  layout_wrong,
  checksum_wrong,
  replay_differs = 29,
  numbers_wrong = 101,  // this and the next: faults of the content
  curves_wrong,
  controls_wrong,
  vertices_wrong,
  triangles_wrong,
  neighbours_wrong,
  normals_wrong,
  tree_wrong,
  shape_wrong,
  block_wrong,
};

/// A status and its sentence.
struct StatusWords {
  Status status;
  const char* sentence;
};
// clang-format off
inline constexpr StatusWords kStatusWords[] = {
    {Status::ok,
     "All is well."},
    {Status::tip_not_finite,
     "The tip position is not a finite number; the force is zero."},
    {Status::tip_teleported,
     "The tip moved farther in one tick than the asset's max_step_m; the force is zero and "
     "contact begins again from outside."},
    {Status::contact_foreign,
     "The contact was used with another asset or other bytes; it was reset and the force "
     "is zero."},
    {Status::force_not_finite,
     "The force was not a finite number; it is zero and the contact was reset."},
    {Status::radius_wrong,
     "The ball's radius is negative or not a finite number; the force is zero."},
    {Status::pose_wrong,
     "A pose is not finite or its quaternion is not of unit length; the force is zero and "
     "contact begins again from outside."},
    {Status::time_step_wrong,
     "The tool has a damper or a ramp, or the body relaxes, and the time step is not "
     "between 1e-5 and 1e6 s; the force is zero."},
    {Status::tool_wrong,
     "A number of the tool is out of range, or the asset does not say how contacts of "
     "several balls move each other."},
    {Status::no_shape,
     "The asset does not say how its surface moves; displacements are zero."},
    {Status::bytes_missing,
     "There are too few bytes for an asset's header."},
    {Status::bytes_misaligned,
     "The bytes do not begin at a multiple of 8, as those of malloc do."},
    {Status::not_an_asset,
     "The bytes do not begin with PALP."},
    {Status::other_endianness,
     "The asset was written with the other byte order."},
    {Status::other_version,
     "The asset's version is not the one this engine reads, or its law is newer."},
    {Status::size_wrong,
     "The size differs from the one in the asset's header."},
    {Status::layout_wrong,
     "The counts or section offsets in the asset's header are impossible."},
    {Status::checksum_wrong,
     "The checksum differs: the asset was changed or cut."},
    {Status::numbers_wrong,
     "The origin, step bound or probe radius is not a finite number in range."},
    {Status::curves_wrong,
     "A spline table is not a clamped basis on increasing knots, with its integrals."},
    {Status::controls_wrong,
     "Control values are not finite, zero at zero and increasing, a side force is more "
     "than the press bears, or a vertex that answers nothing has some."},
    {Status::vertices_wrong,
     "A vertex is not finite or farther than 1 km from the origin."},
    {Status::triangles_wrong,
     "A triangle names a vertex that does not exist, or one twice, or is deeper than the "
     "body."},
    {Status::neighbours_wrong,
     "The triangles' neighbours do not fit each other."},
    {Status::normals_wrong,
     "An inward normal is not a unit vector or does not point through its triangle."},
    {Status::tree_wrong,
     "The bounding tree is not a tree around all triangles that can be touched."},
    {Status::shape_wrong,
     "The shape response has a length, index, weight or number that is impossible."},
    {Status::block_wrong,
     "What the asset says of how its body relaxes, softens or couples contacts, or of where "
     "visual vertices hang, is impossible."},
    {Status::replay_differs,
     "The engine does not reproduce the asset's check forces bit for bit: build it with "
     "-ffp-contract=off and without -ffast-math."},
};
// clang-format on

/// One sentence per status, never null.
inline const char* sentence(Status status) noexcept {
  for (const StatusWords& row : kStatusWords)
    if (row.status == status) return row.sentence;
  return "Unknown status.";
}

}  // namespace palpate::runtime
