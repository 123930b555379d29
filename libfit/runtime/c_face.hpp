// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// What palpate.cpp keeps in the storage of palpate.h's structures, and how the engine's answers
// become those of palpate.h.

#include <cstring>
#include <type_traits>

#include "engine.hpp"
#include "palpate.h"

namespace palpate {
namespace c_face {

namespace rt = palpate::runtime;

constexpr std::uint64_t kAssetMark = 0x50616c7061737365u, kContactMark = 0x50616c70636f6e74u;

struct OpenAsset {
  std::uint64_t mark;
  rt::Asset asset;
};
struct StartedContact {
  std::uint64_t mark;
  rt::Tool tool;
};
static_assert(sizeof(OpenAsset) <= sizeof(palpate_asset), "raise palpate_asset and PALPATE_ABI");
static_assert(sizeof(StartedContact) <= sizeof(palpate_contact),
              "raise palpate_contact and PALPATE_ABI");
static_assert(PALPATE_MAX_BALLS == rt::kMaxContacts, "one bound");
static_assert(PALPATE_MAX_PROFILE == rt::kMaxProfilePoints, "one bound");
static_assert(PALPATE_FLAG_OTHER_RADIUS == rt::kFlagOtherRadius, "one flag");
static_assert(PALPATE_FLAG_CROWDED == rt::kFlagCrowded, "one flag");
static_assert(alignof(OpenAsset) <= alignof(palpate_asset), "storage must suit");
static_assert(std::is_trivially_copyable<OpenAsset>::value, "a plain copy is a copy");
static_assert(std::is_trivially_copyable<StartedContact>::value, "a plain copy is a copy");

// Storage is filled and read by memcpy of the mark, and as the object it holds after that.
// Null of storage that is null or holds none.
template <class Held, class Storage>
Held* held(Storage* storage, std::uint64_t mark) noexcept {
  if (storage == nullptr) return nullptr;
  std::uint64_t found;
  std::memcpy(&found, storage->storage, sizeof found);
  return found == mark ? reinterpret_cast<Held*>(storage->storage) : nullptr;
}
template <class Held, class Storage>
const Held* held(const Storage* storage, std::uint64_t mark) noexcept {
  return held<Held>(const_cast<Storage*>(storage), mark);
}

struct StatusRow {
  rt::Status status;
  palpate_status c;
};
/// Statuses that palpate.h tells apart, the ones with its sentence first; all others are of an
/// asset's content.
constexpr StatusRow kStatuses[] = {
    {rt::Status::ok, PALPATE_OK},
    {rt::Status::tip_not_finite, PALPATE_TIP_NOT_FINITE},
    {rt::Status::tip_teleported, PALPATE_TIP_TELEPORTED},
    {rt::Status::contact_foreign, PALPATE_CONTACT_FOREIGN},
    {rt::Status::force_not_finite, PALPATE_FORCE_NOT_FINITE},
    {rt::Status::pose_wrong, PALPATE_POSE_WRONG},
    {rt::Status::time_step_wrong, PALPATE_TIME_STEP_WRONG},
    {rt::Status::tool_wrong, PALPATE_TOOL_WRONG},
    {rt::Status::radius_wrong, PALPATE_TOOL_WRONG},
    {rt::Status::bytes_missing, PALPATE_BYTES_MISSING},
    {rt::Status::bytes_misaligned, PALPATE_BYTES_MISALIGNED},
    {rt::Status::not_an_asset, PALPATE_NOT_AN_ASSET},
    {rt::Status::other_endianness, PALPATE_OTHER_ENDIANNESS},
    {rt::Status::other_version, PALPATE_OTHER_VERSION},
    {rt::Status::size_wrong, PALPATE_SIZE_WRONG},
    {rt::Status::layout_wrong, PALPATE_LAYOUT_WRONG},
    {rt::Status::checksum_wrong, PALPATE_CHECKSUM_WRONG},
    {rt::Status::replay_differs, PALPATE_REPLAY_DIFFERS},
    {rt::Status::no_shape, PALPATE_NO_SHAPE},
};
inline palpate_status to_c(rt::Status status) noexcept {
  for (const StatusRow& row : kStatuses)
    if (row.status == status) return row.c;
  return PALPATE_CONTENT_WRONG;
}

inline rt::Pose to_pose(const palpate_pose& pose) noexcept {
  rt::Pose out;
  for (int k = 0; k < 3; ++k) out.position_m[k] = pose.position_m[k];
  for (int k = 0; k < 4; ++k) out.orientation[k] = pose.orientation[k];
  return out;
}

inline void copy3(const double from[3], double to[3]) noexcept {
  for (int k = 0; k < 3; ++k) to[k] = from[k];
}

inline void fill(const rt::ToolOutput& from, palpate_output& out) noexcept {
  copy3(from.force_on_tool_N, out.force_on_tool_N);
  copy3(from.torque_on_tool_Nm, out.torque_on_tool_Nm);
  copy3(from.contact_m, out.contact_m);
  copy3(from.normal, out.normal);
  copy3(from.weight, out.weight);
  out.normal_m = from.normal_m;
  out.lateral_m = from.lateral_m;
  out.stored_J = from.stored_J;
  out.dissipated_J = from.dissipated_J;
  out.refused_J = from.refused_J;
  out.refused_ticks = from.refused_ticks;
  out.damped_J = from.damped_J;
  out.triangle = from.triangle;
  out.state = static_cast<std::int32_t>(from.state);
  out.flags = from.flags;
  copy3(from.deflection_m, out.deflection_m);
  copy3(from.acts_at_m, out.acts_at_m);
  out.approach_m_s = from.approach_m_s;
  out.events =
      (from.has_touched ? PALPATE_TOUCHED : 0) | (from.has_released ? PALPATE_RELEASED : 0);
  out.touching = from.touching;
}

inline rt::Status to_shape(const palpate_tool& tool, rt::ToolShape& shape) noexcept {
  if (tool.balls < 1 || tool.balls > PALPATE_MAX_BALLS || tool.reserved_0 != 0)
    return rt::Status::tool_wrong;
  shape.balls = tool.balls;
  for (std::int32_t i = 0; i < tool.balls; ++i) {
    copy3(tool.centre_m[i], shape.ball[i].centre_m);
    shape.ball[i].radius_m = tool.radius_m[i];
    if (tool.met[i] == nullptr) continue;
    const auto* met = held<OpenAsset>(tool.met[i], kAssetMark);
    if (met == nullptr) return rt::Status::tool_wrong;
    shape.ball[i].met = &met->asset;
  }
  shape.damping_Ns_m = tool.damping_Ns_m;
  shape.damper_depth_m = tool.damper_depth_m;
  shape.lateral_damping_Ns_m = tool.lateral_damping_Ns_m;
  shape.max_force_N = tool.max_force_N;
  shape.ramp_s = tool.ramp_s;
  for (double reserved : tool.reserved)
    if (reserved != 0) return rt::Status::tool_wrong;
  return rt::check_tool(shape);
}

inline bool to_indenter(const palpate_indenter& from, rt::Indenter& out) noexcept {
  if (from.reserved_0 != 0 || from.points < 0 || from.points > PALPATE_MAX_PROFILE) return false;
  out.round_end_m = from.round_end_m;
  out.points = from.points;
  for (std::int32_t i = 0; i < from.points; ++i) {
    out.r_m[i] = from.r_m[i];
    out.slope[i] = from.slope[i];
  }
  return rt::is_possible(out);
}

/// All outputs as of tools in the air, refused with a status.
inline palpate_status refuse(palpate_output* out, std::int32_t count,
                             palpate_status status) noexcept {
  for (std::int32_t i = 0; out != nullptr && i < count; ++i) {
    out[i] = palpate_output();
    out[i].triangle = -1;
    out[i].status = status;
  }
  return status;
}

}  // namespace c_face
}  // namespace palpate
