// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
// The engine's C face: checks the caller's pointers, then tool.hpp and asset.hpp do the work.
//   g++ -std=c++17 -O2 -ffp-contract=off -fno-exceptions -fno-rtti -fvisibility=hidden
//       -shared -fPIC palpate.cpp -o libpalpate_engine.so
#include "palpate.h"

#include "c_face.hpp"

using namespace palpate::c_face;

std::int32_t palpate_abi() noexcept { return PALPATE_ABI; }

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
  for (int i = 0; i <= static_cast<int>(rt::Status::replay_differs); ++i) {
    const auto known = static_cast<rt::Status>(i);
    if (to_c(known) == status && status != PALPATE_CONTENT_WRONG && status != PALPATE_TOOL_WRONG)
      return rt::sentence(known);
  }
  switch (status) {
    case PALPATE_NULL_ARGUMENT:
      return "A pointer is null; the force is zero.";
    case PALPATE_ASSET_NOT_OPEN:
      return "The asset was not opened; the force is zero.";
    case PALPATE_NOT_STARTED:
      return "The contact was not started with palpate_start; the force is zero.";
    case PALPATE_TOOL_WRONG:
      return rt::sentence(rt::Status::tool_wrong);
    case PALPATE_BODY_WRONG:
      return "The bytes are no body of this asset, or nothing damages its bodies.";
    case PALPATE_GROUP_WRONG:
      return "A group has 1 to 8 contacts, each once; forces are zero.";
    case PALPATE_HEADER_WRONG:
      return "The program was built with the header of another version of the engine.";
    case PALPATE_VERTICES_WRONG:
      return "Not all of these vertices exist; no displacement was written.";
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
  info->punctures = a.damage.punctures();
  info->tilts = a.leans.nodes.tilts;
  info->couples = a.coupling != nullptr;
  info->meta_json = a.meta;
  info->meta_bytes = a.meta_bytes;
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
  const auto* opened = asset != nullptr ? held<OpenAsset>(asset, kAssetMark) : nullptr;
  return opened != nullptr && opened->asset.damage.is_any() ? rt::body_bytes(opened->asset) : 0;
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
  StartedContact started{kContactMark, rt::ToolContact()};
  const rt::Status status = to_shape(*tool, started.tool.shape);
  if (status == rt::Status::ok) std::memcpy(contact->storage, &started, sizeof started);
  return to_c(status);
}

palpate_status palpate_release(palpate_contact* contact) noexcept {
  if (contact == nullptr) return PALPATE_NULL_ARGUMENT;
  auto* started = held<StartedContact>(contact, kContactMark);
  if (started == nullptr) return PALPATE_NOT_STARTED;
  rt::forget(started->tool.contact);
  return PALPATE_OK;
}

palpate_status palpate_tick(const palpate_asset* asset, palpate_contact* contact,
                            const palpate_input* in, palpate_output* out) noexcept {
  if (out != nullptr) {
    *out = palpate_output();
    out->triangle = -1;
  }
  if (asset == nullptr || contact == nullptr || in == nullptr || out == nullptr)
    return refuse(out, PALPATE_NULL_ARGUMENT);
  const auto* opened = held<OpenAsset>(asset, kAssetMark);
  if (opened == nullptr) return refuse(out, PALPATE_ASSET_NOT_OPEN);
  auto* started = held<StartedContact>(contact, kContactMark);
  if (started == nullptr) return refuse(out, PALPATE_NOT_STARTED);
  rt::ToolOutput answer;
  const rt::Status status =
      rt::touch_tool(opened->asset, started->tool, to_pose(in->tool), to_pose(in->body), in->dt_s,
                     answer, in->wants_tangent != 0 ? out->stiffness_N_m : nullptr);
  fill(answer, *out);
  return refuse(out, to_c(status));
}

palpate_status palpate_turning_start(palpate_turning* turning, const palpate_tool* tool) noexcept {
  if (turning == nullptr) return PALPATE_NULL_ARGUMENT;
  *turning = palpate_turning();
  if (tool == nullptr) return PALPATE_NULL_ARGUMENT;
  StartedTurning started{kTurningMark, rt::TurningTool()};
  rt::Status status = to_shape(*tool, started.tool.shape);
  if (started.tool.shape.has_damper() || !(started.tool.shape.radius_m > 0))
    status = rt::Status::tool_wrong;
  if (status == rt::Status::ok) std::memcpy(turning->storage, &started, sizeof started);
  return to_c(status);
}

palpate_status palpate_turning_release(palpate_turning* turning) noexcept {
  if (turning == nullptr) return PALPATE_NULL_ARGUMENT;
  auto* started = held<StartedTurning>(turning, kTurningMark);
  if (started == nullptr) return PALPATE_NOT_STARTED;
  rt::forget(started->tool.turning);
  return PALPATE_OK;
}

palpate_status palpate_turning_tick(const palpate_asset* asset, palpate_turning* turning,
                                    const palpate_input* in, palpate_output* out) noexcept {
  if (out != nullptr) {
    *out = palpate_output();
    out->triangle = -1;
  }
  if (asset == nullptr || turning == nullptr || in == nullptr || out == nullptr)
    return refuse(out, PALPATE_NULL_ARGUMENT);
  const auto* opened = held<OpenAsset>(asset, kAssetMark);
  if (opened == nullptr) return refuse(out, PALPATE_ASSET_NOT_OPEN);
  auto* started = held<StartedTurning>(turning, kTurningMark);
  if (started == nullptr) return refuse(out, PALPATE_NOT_STARTED);
  rt::TurningToolOutput answer;
  const rt::Status status = rt::touch_turning_tool(opened->asset, started->tool, to_pose(in->tool),
                                                   to_pose(in->body), in->dt_s, answer);
  fill(answer, *out);
  return refuse(out, to_c(status));
}

palpate_status palpate_group_start(palpate_group* group) noexcept {
  if (group == nullptr) return PALPATE_NULL_ARGUMENT;
  *group = palpate_group();
  const StartedGroup started{kGroupMark, rt::Joint()};
  std::memcpy(group->storage, &started, sizeof started);
  return PALPATE_OK;
}

palpate_status palpate_group_tick(const palpate_asset* asset, palpate_group* group,
                                  palpate_contact* const* contacts, const palpate_input* in,
                                  palpate_output* out, std::int32_t count) noexcept {
  if (out == nullptr) return PALPATE_NULL_ARGUMENT;
  const bool is_count = count >= 1 && count <= PALPATE_MAX_TOOLS;
  const auto refuse_all = [&](palpate_status status) noexcept {
    for (std::int32_t i = 0; is_count && i < count; ++i) {
      out[i] = palpate_output();
      out[i].triangle = -1;
      out[i].status = status;
    }
    return status;
  };
  if (!is_count) return PALPATE_GROUP_WRONG;
  if (asset == nullptr || group == nullptr || contacts == nullptr || in == nullptr)
    return refuse_all(PALPATE_NULL_ARGUMENT);
  const auto* opened = held<OpenAsset>(asset, kAssetMark);
  if (opened == nullptr) return refuse_all(PALPATE_ASSET_NOT_OPEN);
  auto* started = held<StartedGroup>(group, kGroupMark);
  if (started == nullptr) return refuse_all(PALPATE_NOT_STARTED);
  rt::ToolContact* tool[rt::kMaxTools];
  for (std::int32_t i = 0; i < count; ++i) {
    if (contacts[i] == nullptr) return refuse_all(PALPATE_NULL_ARGUMENT);
    for (std::int32_t j = 0; j < i; ++j)
      if (contacts[i] == contacts[j]) return refuse_all(PALPATE_GROUP_WRONG);
    auto* contact = held<StartedContact>(contacts[i], kContactMark);
    if (contact == nullptr) return refuse_all(PALPATE_NOT_STARTED);
    tool[i] = &contact->tool;
  }
  rt::ToolOutput answer[rt::kMaxTools];
  rt::Status status[rt::kMaxTools];
  rt::Pose pose[rt::kMaxTools];
  for (std::int32_t i = 0; i < count; ++i) pose[i] = to_pose(in[i].tool);
  rt::touch_tools_together(opened->asset, started->joint, tool, pose, to_pose(in[0].body),
                           in[0].dt_s, answer, status, count);
  palpate_status first = PALPATE_OK;
  for (std::int32_t i = 0; i < count; ++i) {
    out[i] = palpate_output();
    out[i].triangle = -1;
    fill(answer[i], out[i]);
    out[i].status = to_c(status[i]);
    if (first == PALPATE_OK) first = out[i].status;
  }
  return first;
}

palpate_status palpate_compound_start(palpate_compound* compound, const palpate_tool* balls,
                                      std::int32_t count) noexcept {
  if (compound == nullptr) return PALPATE_NULL_ARGUMENT;
  *compound = palpate_compound();
  if (balls == nullptr) return PALPATE_NULL_ARGUMENT;
  if (count < 1 || count > PALPATE_MAX_TOOLS) return PALPATE_TOOL_WRONG;
  StartedCompound started{kCompoundMark, rt::CompoundTool()};
  rt::CompoundShape& shape = started.tool.shape;
  shape.balls = count;
  for (std::int32_t i = 0; i < count; ++i) {
    rt::ToolShape ball;
    if (to_shape(balls[i], ball) != rt::Status::ok || ball.has_damper() || !(ball.radius_m > 0) ||
        ball.radius_m != balls[0].radius_m)
      return PALPATE_TOOL_WRONG;
    copy3(ball.offset_m, shape.centre_m[i]);
    if (i == 0) shape.limits = ball;
  }
  shape.radius_m = shape.limits.radius_m;
  std::memcpy(compound->storage, &started, sizeof started);
  return PALPATE_OK;
}

palpate_status palpate_compound_release(palpate_compound* compound) noexcept {
  if (compound == nullptr) return PALPATE_NULL_ARGUMENT;
  auto* started = held<StartedCompound>(compound, kCompoundMark);
  if (started == nullptr) return PALPATE_NOT_STARTED;
  rt::forget(started->tool);
  return PALPATE_OK;
}

palpate_status palpate_compound_tick(const palpate_asset* asset, palpate_compound* compound,
                                     const palpate_input* in, palpate_output* out) noexcept {
  if (out != nullptr) {
    *out = palpate_output();
    out->triangle = -1;
  }
  if (asset == nullptr || compound == nullptr || in == nullptr || out == nullptr)
    return refuse(out, PALPATE_NULL_ARGUMENT);
  const auto* opened = held<OpenAsset>(asset, kAssetMark);
  if (opened == nullptr) return refuse(out, PALPATE_ASSET_NOT_OPEN);
  auto* started = held<StartedCompound>(compound, kCompoundMark);
  if (started == nullptr) return refuse(out, PALPATE_NOT_STARTED);
  rt::CompoundOutput answer;
  const rt::Status status = rt::touch_compound_tool(opened->asset, started->tool, to_pose(in->tool),
                                                    to_pose(in->body), in->dt_s, answer);
  fill(answer, started->tool.shape.balls, *out);
  return refuse(out, to_c(status));
}

palpate_status palpate_deform(const palpate_asset* asset, const palpate_contact* contact,
                              std::int32_t first, std::int32_t count,
                              float* displacement_m) noexcept {
  if (displacement_m == nullptr) return PALPATE_NULL_ARGUMENT;
  if (first < 0 || count < 0) return PALPATE_VERTICES_WRONG;
  const auto* opened = asset != nullptr ? held<OpenAsset>(asset, kAssetMark) : nullptr;
  if (opened != nullptr && count > opened->asset.vertices - first) return PALPATE_VERTICES_WRONG;
  for (std::int64_t i = 0; i < 3 * std::int64_t{count}; ++i) displacement_m[i] = 0;
  if (asset == nullptr || contact == nullptr) return PALPATE_NULL_ARGUMENT;
  if (opened == nullptr) return PALPATE_ASSET_NOT_OPEN;
  const auto* started = held<StartedContact>(contact, kContactMark);
  if (started == nullptr) return PALPATE_NOT_STARTED;
  const rt::ToolContact& tool = started->tool;
  return to_c(
      rt::deform(opened->asset, tool.contact, tool.shape.radius_m, first, count, displacement_m));
}
