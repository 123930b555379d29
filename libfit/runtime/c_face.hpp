// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// What palpate.cpp keeps in the storage of palpate.h's structures, and how the engine's answers
// become those of palpate.h.

#include <cstring>
#include <type_traits>

#include "engine.hpp"
#include "palpate.h"
#include "tool/compound_tool.hpp"
#include "tool/several_tools.hpp"
#include "tool/turning_tool.hpp"

namespace palpate {
namespace c_face {

namespace rt = palpate::runtime;

constexpr std::uint64_t kAssetMark = 0x50616c7061737365u, kContactMark = 0x50616c70636f6e74u,
                        kTurningMark = 0x50616c707475726eu, kGroupMark = 0x50616c7067726f75u,
                        kCompoundMark = 0x50616c70636f6d70u;

struct OpenAsset {
  std::uint64_t mark;
  rt::Asset asset;
};
struct StartedContact {
  std::uint64_t mark;
  rt::ToolContact tool;
};
struct StartedTurning {
  std::uint64_t mark;
  rt::TurningTool tool;
};
static_assert(sizeof(StartedTurning) <= sizeof(palpate_turning),
              "raise palpate_turning and PALPATE_ABI");
static_assert(std::is_trivially_copyable<StartedTurning>::value, "a plain copy is a copy");
static_assert(sizeof(OpenAsset) <= sizeof(palpate_asset), "raise palpate_asset and PALPATE_ABI");
static_assert(sizeof(StartedContact) <= sizeof(palpate_contact),
              "raise palpate_contact and PALPATE_ABI");
struct StartedGroup {
  std::uint64_t mark;
  rt::Joint joint;
};
static_assert(sizeof(StartedGroup) <= sizeof(palpate_group), "raise palpate_group and PALPATE_ABI");
struct StartedCompound {
  std::uint64_t mark;
  rt::CompoundTool tool;
};
static_assert(sizeof(StartedCompound) <= sizeof(palpate_compound),
              "raise palpate_compound and PALPATE_ABI");
static_assert(std::is_trivially_copyable<StartedCompound>::value, "a plain copy is a copy");
static_assert(PALPATE_MAX_TOOLS == rt::kMaxTools, "one bound");
static_assert(PALPATE_FLAG_CROWDED == rt::kFlagCrowded, "one flag");
static_assert(alignof(OpenAsset) <= alignof(palpate_asset), "storage must suit");
static_assert(std::is_trivially_copyable<OpenAsset>::value, "a plain copy is a copy");
static_assert(std::is_trivially_copyable<StartedContact>::value, "a plain copy is a copy");

// Storage is filled and read by memcpy of the mark, and as the object it holds after that.
template <class Held, class Storage>
Held* held(Storage* storage, std::uint64_t mark) noexcept {
  std::uint64_t found;
  std::memcpy(&found, storage->storage, sizeof found);
  return found == mark ? reinterpret_cast<Held*>(storage->storage) : nullptr;
}
template <class Held, class Storage>
const Held* held(const Storage* storage, std::uint64_t mark) noexcept {
  return held<Held>(const_cast<Storage*>(storage), mark);
}

inline palpate_status to_c(rt::Status status) noexcept {
  switch (status) {
    case rt::Status::ok:
      return PALPATE_OK;
    case rt::Status::tip_not_finite:
      return PALPATE_TIP_NOT_FINITE;
    case rt::Status::tip_teleported:
      return PALPATE_TIP_TELEPORTED;
    case rt::Status::contact_foreign:
      return PALPATE_CONTACT_FOREIGN;
    case rt::Status::force_not_finite:
      return PALPATE_FORCE_NOT_FINITE;
    case rt::Status::pose_wrong:
      return PALPATE_POSE_WRONG;
    case rt::Status::time_step_wrong:
      return PALPATE_TIME_STEP_WRONG;
    case rt::Status::radius_wrong:
    case rt::Status::tool_wrong:
      return PALPATE_TOOL_WRONG;
    case rt::Status::bytes_missing:
      return PALPATE_BYTES_MISSING;
    case rt::Status::bytes_misaligned:
      return PALPATE_BYTES_MISALIGNED;
    case rt::Status::not_an_asset:
      return PALPATE_NOT_AN_ASSET;
    case rt::Status::other_endianness:
      return PALPATE_OTHER_ENDIANNESS;
    case rt::Status::other_version:
      return PALPATE_OTHER_VERSION;
    case rt::Status::size_wrong:
      return PALPATE_SIZE_WRONG;
    case rt::Status::layout_wrong:
      return PALPATE_LAYOUT_WRONG;
    case rt::Status::checksum_wrong:
      return PALPATE_CHECKSUM_WRONG;
    case rt::Status::replay_differs:
      return PALPATE_REPLAY_DIFFERS;
    case rt::Status::no_shape:
      return PALPATE_NO_SHAPE;
    default:
      return PALPATE_CONTENT_WRONG;
  }
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

inline void fill(const rt::Output& body, palpate_output& out) noexcept {
  copy3(body.weight, out.weight);
  out.normal_m = body.normal_m;
  out.lateral_m = body.lateral_m;
  out.stored_J = body.stored_J;
  out.dissipated_J = body.dissipated_J;
  out.refused_J = body.refused_J;
  out.refused_ticks = body.refused_ticks;
  out.triangle = body.triangle;
  out.state = static_cast<std::int32_t>(body.state);
  out.flags = body.flags;
}

inline void fill(const rt::ToolOutput& from, palpate_output& out) noexcept {
  fill(from.body, out);
  copy3(from.force_on_tool_N, out.force_on_tool_N);
  copy3(from.torque_on_tool_Nm, out.torque_on_tool_Nm);
  copy3(from.contact_m, out.contact_m);
  copy3(from.normal, out.normal);
  copy3(from.deflection_m, out.deflection_m);
  copy3(from.acts_at_m, out.acts_at_m);
  out.approach_m_s = from.approach_m_s;
  out.events = (from.has_touched ? PALPATE_TOUCHED : 0) |
               (from.has_released ? PALPATE_RELEASED : 0) |
               ((from.body.flags & rt::kFlagPunctured) != 0 ? PALPATE_PUNCTURED : 0);
  out.damped_J = from.damped_J;
  out.damper_N = from.damper_N;
}

// What tools that turn have in common: the wrench, where it acts, and events.
template <class From>
void fill_turning(const From& from, palpate_output& out) noexcept {
  copy3(from.force_on_tool_N, out.force_on_tool_N);
  copy3(from.torque_on_tool_Nm, out.torque_on_tool_Nm);
  copy3(from.contact_m, out.contact_m);
  copy3(from.normal, out.normal);
  copy3(from.acts_at_m, out.acts_at_m);
  for (int k = 0; k < 3; ++k) out.deflection_m[k] = from.acts_at_m[k] - from.contact_m[k];
  out.events =
      (from.has_touched ? PALPATE_TOUCHED : 0) | (from.has_released ? PALPATE_RELEASED : 0);
}

inline void fill(const rt::TurningToolOutput& from, palpate_output& out) noexcept {
  fill(from.body.tick, out);
  fill_turning(from, out);
  out.stored_J = from.body.stored_J;
  out.dissipated_J = from.body.dissipated_J;
  out.flags = from.body.flags;
}

inline void fill(const rt::CompoundOutput& from, int balls, palpate_output& out) noexcept {
  fill_turning(from, out);
  for (int i = 0; i < balls; ++i) {
    const auto state = static_cast<std::int32_t>(from.ball[i].state);
    if (state > out.state) out.state = state;
  }
  out.stored_J = from.stored_J;
  out.dissipated_J = from.dissipated_J;
  out.refused_J = from.refused_J;
  out.refused_ticks = from.refused_ticks;
  out.flags = from.flags;
}

inline rt::Status to_shape(const palpate_tool& tool, rt::ToolShape& shape) noexcept {
  copy3(tool.offset_m, shape.offset_m);
  shape.radius_m = tool.radius_m;
  shape.damping_Ns_m = tool.damping_Ns_m;
  shape.damper_depth_m = tool.damper_depth_m;
  shape.lateral_damping_Ns_m = tool.lateral_damping_Ns_m;
  shape.max_force_N = tool.max_force_N;
  shape.ramp_s = tool.ramp_s;
  for (double reserved : tool.reserved)
    if (reserved != 0) return rt::Status::tool_wrong;
  return rt::check_tool(shape);
}

inline palpate_status refuse(palpate_output* out, palpate_status status) noexcept {
  if (out != nullptr) out->status = status;
  return status;
}

}  // namespace c_face
}  // namespace palpate
