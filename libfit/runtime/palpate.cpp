// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
// The engine's C face: checks the caller's pointers, then tool.hpp and asset.hpp do the work.
//   g++ -std=c++17 -O2 -ffp-contract=off -fno-exceptions -fno-rtti -fvisibility=hidden
//       -shared -fPIC palpate.cpp -o libpalpate_engine.so
#include "palpate.h"

#include <cstring>
#include <type_traits>

#include "engine.hpp"

namespace {

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

static_assert(int(rt::Status::no_shape) == PALPATE_NO_SHAPE, "one number");
static_assert(int(rt::Status::tip_not_finite) == PALPATE_TIP_NOT_FINITE, "one number");
static_assert(int(rt::Status::bytes_missing) == PALPATE_BYTES_MISSING, "one number");
static_assert(int(rt::Status::checksum_wrong) == PALPATE_CHECKSUM_WRONG, "one number");
static_assert(int(rt::Status::replay_differs) == PALPATE_REPLAY_DIFFERS, "one number");

palpate_status to_c(rt::Status status) noexcept {
  if (status == rt::Status::radius_wrong) return PALPATE_TOOL_WRONG;
  const int number = static_cast<int>(status);
  return number < 100 ? number : PALPATE_CONTENT_WRONG;
}

rt::Pose to_pose(const palpate_pose& pose) noexcept {
  rt::Pose out;
  for (int k = 0; k < 3; ++k) out.position_m[k] = pose.position_m[k];
  for (int k = 0; k < 4; ++k) out.orientation[k] = pose.orientation[k];
  return out;
}

void copy3(const double from[3], double to[3]) noexcept {
  for (int k = 0; k < 3; ++k) to[k] = from[k];
}

void fill(const rt::ToolOutput& from, palpate_output& out) noexcept {
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

rt::Status to_shape(const palpate_tool& tool, rt::ToolShape& shape) noexcept {
  if (tool.balls < 1 || tool.balls > PALPATE_MAX_BALLS || tool.reserved_0 != 0)
    return rt::Status::tool_wrong;
  shape.balls = tool.balls;
  for (std::int32_t i = 0; i < tool.balls; ++i) {
    copy3(tool.centre_m[i], shape.ball[i].centre_m);
    shape.ball[i].radius_m = tool.radius_m[i];
    if (tool.ball_asset[i] == nullptr) continue;
    const auto* opened = held<OpenAsset>(tool.ball_asset[i], kAssetMark);
    if (opened == nullptr) return rt::Status::tool_wrong;
    shape.ball[i].asset = &opened->asset;
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

bool to_indenter(const palpate_indenter& from, rt::Indenter& out) noexcept {
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
palpate_status refuse(palpate_output* out, std::int32_t count, palpate_status status) noexcept {
  for (std::int32_t i = 0; out != nullptr && i < count; ++i) {
    out[i] = palpate_output();
    out[i].triangle = -1;
    out[i].status = status;
  }
  return status;
}

}  // namespace

palpate_status palpate_sizes_fit(std::int32_t abi, const std::uint32_t bytes[8]) noexcept {
  if (bytes == nullptr) return PALPATE_NULL_ARGUMENT;
  constexpr std::size_t kBytes[8] = {
      sizeof(palpate_asset), sizeof(palpate_contact), sizeof(palpate_pose), sizeof(palpate_tool),
      sizeof(palpate_input), sizeof(palpate_output),  sizeof(palpate_info), sizeof(palpate_mesh)};
  bool fits = abi == PALPATE_ABI;
  for (std::size_t i = 0; fits && i < 8; ++i) fits = bytes[i] == kBytes[i];
  return fits ? PALPATE_OK : PALPATE_HEADER_WRONG;
}

const char* palpate_sentence(palpate_status status) noexcept {
  for (const rt::StatusWords& row : rt::kStatusWords)
    if (static_cast<int>(row.status) == status && status < 100) return row.sentence;
  switch (status) {
    case PALPATE_NULL_ARGUMENT:
      return "A pointer is null; the force is zero.";
    case PALPATE_ASSET_NOT_OPEN:
      return "The asset was not opened; the force is zero.";
    case PALPATE_NOT_STARTED:
      return "The contact was not started with palpate_start; the force is zero.";
    case PALPATE_BODY_WRONG:
      return "The bytes are no body of this asset, or nothing damages its bodies.";
    case PALPATE_COUNT_WRONG:
      return "1 to 8 tools are ticked together, with 8 balls at most between them; forces are "
             "zero.";
    case PALPATE_HEADER_WRONG:
      return "The program was built with the header of another version of the engine.";
    case PALPATE_VERTICES_WRONG:
      return "Not all of these vertices exist; nothing was written.";
    case PALPATE_CONTENT_WRONG:
      return "Numbers, curves, triangles, normals or the tree of the asset are not what they must "
             "be.";
    default:
      return "Unknown status.";
  }
}

palpate_status palpate_open(palpate_asset* asset, const void* bytes, std::uint64_t size) noexcept {
  if (asset == nullptr) return PALPATE_NULL_ARGUMENT;
  *asset = palpate_asset();
  rt::Status status;
  const OpenAsset opened{kAssetMark,
                         rt::Asset::open(bytes, static_cast<std::size_t>(size), &status)};
  if (status == rt::Status::ok) std::memcpy(asset->storage, &opened, sizeof opened);
  return to_c(status);
}

palpate_status palpate_describe(const palpate_asset* asset, palpate_info* info) noexcept {
  if (info == nullptr) return PALPATE_NULL_ARGUMENT;
  *info = palpate_info();
  if (asset == nullptr) return PALPATE_NULL_ARGUMENT;
  const auto* opened = held<OpenAsset>(asset, kAssetMark);
  if (opened == nullptr) return PALPATE_ASSET_NOT_OPEN;
  const rt::Asset& a = opened->asset;
  info->vertices = a.vertices;
  info->triangles = a.triangles;
  info->max_step_m = a.max_step_m;
  info->probe_radius_m = a.probe_radius_m;
  for (int k = 0; k < 3; ++k) {
    info->box_min_m[k] = a.origin_m[k] + double(a.tree[0].lo[k]);
    info->box_max_m[k] = a.origin_m[k] + double(a.tree[0].hi[k]);
  }
  info->range_m = a.max_fitted_m;
  info->checksum = a.checksum;
  info->law = rt::row_of(static_cast<rt::Family>(a.curves.family)).name;
  info->has_guard = a.has_guard;
  info->has_shape = a.shape.points > 0;
  info->relaxes = a.curves.relaxation.branches > 0;
  info->softens = a.damage.softens();
  info->couples = a.coupling != nullptr;
  info->visual_vertices = a.visual.vertices;
  info->meta_json = a.file.meta;
  info->meta_bytes = a.file.meta_bytes;
  return PALPATE_OK;
}

palpate_status palpate_read_mesh(const palpate_asset* asset, palpate_mesh* mesh) noexcept {
  if (mesh == nullptr) return PALPATE_NULL_ARGUMENT;
  *mesh = palpate_mesh();
  if (asset == nullptr) return PALPATE_NULL_ARGUMENT;
  const auto* opened = held<OpenAsset>(asset, kAssetMark);
  if (opened == nullptr) return PALPATE_ASSET_NOT_OPEN;
  const rt::Asset& a = opened->asset;
  mesh->vertices = a.vertices;
  mesh->triangles = a.triangles;
  copy3(a.origin_m, mesh->origin_m);
  mesh->vertex_m = a.vertex;
  mesh->inward_normal = a.normal;
  mesh->covered = a.covered;
  mesh->triangle = a.triangle;
  return PALPATE_OK;
}

std::uint64_t palpate_body_bytes(const palpate_asset* asset) noexcept {
  const auto* opened = held<OpenAsset>(asset, kAssetMark);
  return opened != nullptr && opened->asset.damage.softens() ? rt::body_bytes(opened->asset) : 0;
}

palpate_status palpate_body_start(const palpate_asset* asset, void* body,
                                  std::uint64_t bytes) noexcept {
  if (asset == nullptr || body == nullptr) return PALPATE_NULL_ARGUMENT;
  const auto* opened = held<OpenAsset>(asset, kAssetMark);
  if (opened == nullptr) return PALPATE_ASSET_NOT_OPEN;
  if (palpate_body_bytes(asset) == 0 || bytes != palpate_body_bytes(asset) ||
      reinterpret_cast<std::uintptr_t>(body) % 8 != 0)
    return PALPATE_BODY_WRONG;
  rt::start_body(opened->asset, body);
  return PALPATE_OK;
}

palpate_status palpate_body_open(palpate_asset* opened_body, const palpate_asset* asset, void* body,
                                 std::uint64_t bytes) noexcept {
  if (opened_body == nullptr || asset == nullptr || body == nullptr) return PALPATE_NULL_ARGUMENT;
  const auto* opened = held<OpenAsset>(asset, kAssetMark);
  if (opened == nullptr) return PALPATE_ASSET_NOT_OPEN;
  if (palpate_body_bytes(asset) == 0 || !rt::is_body(opened->asset, body, bytes))
    return PALPATE_BODY_WRONG;
  OpenAsset with = *opened;
  static_cast<rt::AssetView&>(with.asset) = rt::with_body(opened->asset, body);
  std::memcpy(opened_body->storage, &with, sizeof with);
  return PALPATE_OK;
}

std::uint64_t palpate_indenter_bytes(const palpate_asset* asset) noexcept {
  const auto* opened = held<OpenAsset>(asset, kAssetMark);
  return opened != nullptr && rt::knows_radius(opened->asset) ? rt::indenter_bytes(opened->asset)
                                                              : 0;
}

palpate_status palpate_indenter_open(palpate_asset* opened_for, const palpate_asset* asset,
                                     const palpate_indenter* indenter, void* memory,
                                     std::uint64_t bytes) noexcept {
  if (opened_for == nullptr || asset == nullptr || indenter == nullptr || memory == nullptr)
    return PALPATE_NULL_ARGUMENT;
  const auto* opened = held<OpenAsset>(asset, kAssetMark);
  if (opened == nullptr) return PALPATE_ASSET_NOT_OPEN;
  rt::Indenter tool;
  if (!to_indenter(*indenter, tool) || palpate_indenter_bytes(asset) == 0 ||
      bytes != palpate_indenter_bytes(asset) || reinterpret_cast<std::uintptr_t>(memory) % 8 != 0)
    return PALPATE_TOOL_WRONG;
  OpenAsset with = *opened;
  static_cast<rt::AssetView&>(with.asset) = rt::with_indenter(opened->asset, tool, memory);
  if (!(with.asset.max_fitted_m > 0)) return PALPATE_TOOL_WRONG;  // wider than what is known
  std::memcpy(opened_for->storage, &with, sizeof with);
  return PALPATE_OK;
}

void palpate_close(palpate_asset* asset) noexcept {
  if (asset != nullptr) *asset = palpate_asset();
}

void* palpate_copy_aligned(void* room, std::uint64_t room_bytes, const void* bytes,
                           std::uint64_t size) noexcept {
  if (room == nullptr || bytes == nullptr) return nullptr;
  const auto at = reinterpret_cast<std::uintptr_t>(room);
  const std::uint64_t skip = (rt::kAlignment - at % rt::kAlignment) % rt::kAlignment;
  if (room_bytes < skip || room_bytes - skip < size) return nullptr;
  return std::memcpy(static_cast<unsigned char*>(room) + skip, bytes,
                     static_cast<std::size_t>(size));
}

palpate_status palpate_start(palpate_contact* contact, const palpate_tool* tool) noexcept {
  if (contact == nullptr) return PALPATE_NULL_ARGUMENT;
  *contact = palpate_contact();
  if (tool == nullptr) return PALPATE_NULL_ARGUMENT;
  StartedContact started{kContactMark, rt::Tool()};
  const rt::Status status = to_shape(*tool, started.tool.shape);
  if (status == rt::Status::ok) std::memcpy(contact->storage, &started, sizeof started);
  return to_c(status);
}

palpate_status palpate_release(palpate_contact* contact) noexcept {
  if (contact == nullptr) return PALPATE_NULL_ARGUMENT;
  auto* started = held<StartedContact>(contact, kContactMark);
  if (started == nullptr) return PALPATE_NOT_STARTED;
  rt::forget(started->tool);
  return PALPATE_OK;
}

palpate_status palpate_tick(const palpate_asset* asset, palpate_contact* contacts,
                            std::int32_t count, const palpate_input* in,
                            palpate_output* out) noexcept {
  if (count < 1 || count > PALPATE_MAX_BALLS) return refuse(out, count, PALPATE_COUNT_WRONG);
  if (asset == nullptr || contacts == nullptr || in == nullptr || out == nullptr)
    return refuse(out, count, PALPATE_NULL_ARGUMENT);
  const auto* opened = held<OpenAsset>(asset, kAssetMark);
  if (opened == nullptr) return refuse(out, count, PALPATE_ASSET_NOT_OPEN);
  rt::Tool* tool[PALPATE_MAX_BALLS];
  int balls = 0;
  for (std::int32_t i = 0; i < count; ++i) {
    auto* started = held<StartedContact>(contacts + i, kContactMark);
    if (started == nullptr) return refuse(out, count, PALPATE_NOT_STARTED);
    tool[i] = &started->tool;
    balls += tool[i]->shape.balls;
  }
  if (balls > PALPATE_MAX_BALLS) return refuse(out, count, PALPATE_COUNT_WRONG);
  rt::Room<rt::ToolInput, PALPATE_MAX_BALLS> input;
  rt::Room<rt::ToolOutput, PALPATE_MAX_BALLS> answer;
  rt::Status status[PALPATE_MAX_BALLS];
  for (std::int32_t i = 0; i < count; ++i) {
    out[i] = palpate_output();
    rt::ToolInput& asked = input.make(i);
    asked.pose = to_pose(in[i].tool);
    asked.body = to_pose(in[i].body);
    asked.dt_s = in[i].dt_s;
    if (in[i].wants_tangent != 0) asked.tangent_N_m = out[i].stiffness_N_m;
    answer.make(i);
  }
  rt::touch_tools(opened->asset, tool, input.begin(), answer.begin(), status, count);
  palpate_status first = PALPATE_OK;
  for (std::int32_t i = 0; i < count; ++i) {
    fill(answer[i], out[i]);
    out[i].status = to_c(status[i]);
    if (first == PALPATE_OK) first = out[i].status;
  }
  return first;
}

palpate_status palpate_deform(const palpate_asset* asset, const palpate_contact* contacts,
                              std::int32_t count, std::int32_t first, std::int32_t vertices,
                              float* displacement_m) noexcept {
  if (displacement_m == nullptr) return PALPATE_NULL_ARGUMENT;
  if (first < 0 || vertices < 0) return PALPATE_VERTICES_WRONG;
  const auto* opened = held<OpenAsset>(asset, kAssetMark);
  if (opened != nullptr && vertices > opened->asset.vertices - first) return PALPATE_VERTICES_WRONG;
  for (std::int64_t i = 0; i < 3 * std::int64_t{vertices}; ++i) displacement_m[i] = 0;
  if (asset == nullptr || contacts == nullptr) return PALPATE_NULL_ARGUMENT;
  if (opened == nullptr) return PALPATE_ASSET_NOT_OPEN;
  if (count < 1 || count > PALPATE_MAX_BALLS) return PALPATE_COUNT_WRONG;
  rt::Dent dent[PALPATE_MAX_BALLS];
  int dents = 0;
  for (std::int32_t i = 0; i < count; ++i) {
    const auto* started = held<StartedContact>(contacts + i, kContactMark);
    if (started == nullptr) return PALPATE_NOT_STARTED;
    const rt::Tool& tool = started->tool;
    for (int k = 0; k < tool.shape.balls; ++k) {
      if (dents == PALPATE_MAX_BALLS) return PALPATE_COUNT_WRONG;
      dent[dents++] = {&tool.contact[k], tool.shape.ball[k].radius_m, tool.shape.ball[k].asset};
    }
  }
  return to_c(rt::deform(opened->asset, dent, dents, first, vertices, displacement_m));
}

palpate_status palpate_place_visual(const palpate_asset* asset, const float* displacement_m,
                                    std::int32_t first, std::int32_t vertices,
                                    float* place_m) noexcept {
  if (asset == nullptr || place_m == nullptr) return PALPATE_NULL_ARGUMENT;
  const auto* opened = held<OpenAsset>(asset, kAssetMark);
  if (opened == nullptr) return PALPATE_ASSET_NOT_OPEN;
  if (first < 0 || vertices < 0 || vertices > opened->asset.visual.vertices - first)
    return PALPATE_VERTICES_WRONG;
  for (std::int32_t i = 0; i < vertices; ++i, place_m += 3) {
    const rt::Vec3d place = rt::visual_place(opened->asset, first + i, displacement_m);
    place_m[0] = static_cast<float>(place.x);
    place_m[1] = static_cast<float>(place.y);
    place_m[2] = static_cast<float>(place.z);
  }
  return PALPATE_OK;
}
