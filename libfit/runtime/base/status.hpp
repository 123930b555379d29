// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

#include "rounding.hpp"

namespace palpate {
namespace runtime {

/// What the engine has to say, when opening an asset and at every tick.
enum class Status {
  ok,
  // ticks: the force is zero whenever one of these comes back
  tip_not_finite,
  tip_teleported,
  contact_foreign,
  force_not_finite,
  radius_wrong,
  pose_wrong,
  time_step_wrong,
  tool_wrong,
  no_shape,  // displacements are zero
  // opening an asset
  bytes_missing,
  bytes_misaligned,
  not_an_asset,
  other_endianness,
  other_version,
  size_wrong,
  layout_wrong,
  checksum_wrong,
  numbers_wrong,
  curves_wrong,
  controls_wrong,
  vertices_wrong,
  triangles_wrong,
  neighbours_wrong,
  normals_wrong,
  tree_wrong,
  shape_wrong,
  block_wrong,
  replay_differs,
};

/// One sentence per status, never null.
inline const char* sentence(Status status) noexcept {
  switch (status) {
    case Status::ok:
      return "All is well.";
    case Status::tip_not_finite:
      return "The tip position is not a finite number; the force is zero.";
    case Status::tip_teleported:
      return "The tip moved farther in one tick than the asset's max_step_m; the force is zero and "
             "contact begins again from outside.";
    case Status::contact_foreign:
      return "The contact was used with another asset or other bytes; it was reset and the force "
             "is "
             "zero.";
    case Status::force_not_finite:
      return "The force was not a finite number; it is zero and the contact was reset.";
    case Status::radius_wrong:
      return "The ball's radius is negative or not a finite number; the force is zero.";
    case Status::pose_wrong:
      return "A pose is not finite or its quaternion is not of unit length; "
             "the force is zero and contact begins again from outside.";
    case Status::time_step_wrong:
      return "The tool has a damper or a ramp, or the body relaxes, and the time step is not "
             "between "
             "1e-5 and 1e6 s; the force is zero.";
    case Status::tool_wrong:
      return "A number of the tool is out of range, or the asset does not say how contacts of "
             "several "
             "balls move each other.";
    case Status::no_shape:
      return "The asset does not say how its surface moves; displacements are zero.";
    case Status::bytes_missing:
      return "There are too few bytes for an asset's header.";
    case Status::bytes_misaligned:
      return "The bytes do not begin at a multiple of 8, as those of malloc do.";
    case Status::not_an_asset:
      return "The bytes do not begin with PALP.";
    case Status::other_endianness:
      return "The asset was written with the other byte order.";
    case Status::other_version:
      return "The asset's version is not the one this engine reads, or its law is newer.";
    case Status::size_wrong:
      return "The size differs from the one in the asset's header.";
    case Status::layout_wrong:
      return "The counts or section offsets in the asset's header are impossible.";
    case Status::checksum_wrong:
      return "The checksum differs: the asset was changed or cut.";
    case Status::numbers_wrong:
      return "The origin, step bound or probe radius is not a finite number in range.";
    case Status::curves_wrong:
      return "A spline table is not a clamped basis on increasing knots, with its integrals.";
    case Status::controls_wrong:
      return "Control values are not finite, zero at zero and increasing, a side force is "
             "more than the press bears, or a vertex that answers nothing has some.";
    case Status::vertices_wrong:
      return "A vertex is not finite or farther than 1 km from the origin.";
    case Status::triangles_wrong:
      return "A triangle names a vertex that does not exist, or one twice, or is deeper than the "
             "body.";
    case Status::neighbours_wrong:
      return "The triangles' neighbours do not fit each other.";
    case Status::normals_wrong:
      return "An inward normal is not a unit vector or does not point through its triangle.";
    case Status::tree_wrong:
      return "The bounding tree is not a tree around all triangles that can be touched.";
    case Status::shape_wrong:
      return "The shape response has a length, index, weight or number that is impossible.";
    case Status::block_wrong:
      return "What the asset says of how its body relaxes, softens or couples contacts is "
             "impossible.";
    case Status::replay_differs:
      return "The engine does not reproduce the asset's check forces bit for bit: build it with "
             "-ffp-contract=off and without -ffast-math.";
  }
  return "Unknown status.";
}

}  // namespace runtime
}  // namespace palpate
