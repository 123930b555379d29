// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// A body that contacts damage: the energies it has stored, in memory of the caller's beside the
// asset, and how it softens (docs/method-body.md, section 26). Any number of bodies may share an
// asset; contacts that press one body belong to one thread. The bytes are plain: copy them to save,
// put them back and open them again to restore, start them again to heal.

#include "contact.hpp"

namespace palpate::runtime {

constexpr std::uint64_t kBodyMark = 0x70616c70626f6479u;

/// The first bytes of a body.
struct BodyHeader {
  std::uint64_t mark;
  std::uint64_t asset_checksum;
  std::int64_t vertices;
  std::uint64_t reserved[5];  ///< 0
};
static_assert(sizeof(BodyHeader) == 64, "the header of a body is packed");

/// Damage of a vertex. Energies are over unit_J, the law's at the end of the vertex's normal curve,
/// so that stiff and soft places that were strained alike are damaged alike.
struct DamagedVertex {
  float most;  ///< the largest so far
  float unit_J;
};

inline std::uint64_t body_bytes(const AssetView& asset) noexcept {
  const std::uint64_t softening = asset.damage.softens() ? asset.vertices : 0;
  return sizeof(BodyHeader) + sizeof(DamagedVertex) * softening;
}

/// Energy under a vertex's normal curve [J].
inline double unit_energy(const AssetView& asset, int vertex) noexcept {
  const SplineView& spline = asset.curves.view[kNormal];
  return curve_energy(spline, asset.node(vertex) + asset.control_offset[kNormal],
                      spline.knots[spline.pieces]);
}

/// The asset with a body in `memory`, which is_body(): touch() it in place of the asset. The memory
/// must outlive it.
inline AssetView with_body(const AssetView& asset, void* memory) noexcept {
  AssetView out = asset;
  auto* bytes = static_cast<unsigned char*>(memory);
  if (asset.damage.softens())
    out.body = reinterpret_cast<DamagedVertex*>(bytes + sizeof(BodyHeader));
  return out;
}

/// A new body in `memory` [body_bytes(asset)], 8-byte aligned. One that was there is healed; its
/// contacts must be forgotten.
inline void start_body(const AssetView& asset, void* memory) noexcept {
  BodyHeader header = {};
  header.mark = kBodyMark;
  header.asset_checksum = asset.checksum;
  header.vertices = asset.vertices;
  std::memcpy(memory, &header, sizeof header);
  const AssetView body = with_body(asset, memory);
  if (body.body != nullptr)
    for (int v = 0; v < asset.vertices; ++v)
      body.body[v] = {0, static_cast<float>(unit_energy(asset, v))};
}

/// Returns true if bytes [size], 8-byte aligned, are a body of the asset. Safe on hostile bytes.
inline bool is_body(const AssetView& asset, const void* memory, std::uint64_t size) noexcept {
  if (memory == nullptr || asset.vertices <= 0 || size != body_bytes(asset) ||
      reinterpret_cast<std::uintptr_t>(memory) % 8 != 0)
    return false;
  BodyHeader header;
  std::memcpy(&header, memory, sizeof header);
  if (header.mark != kBodyMark || header.asset_checksum != asset.checksum ||
      header.vertices != asset.vertices)
    return false;
  for (const std::uint64_t reserved : header.reserved)
    if (reserved != 0) return false;
  const AssetView body = with_body(asset, const_cast<void*>(memory));
  for (int v = 0; body.body != nullptr && v < asset.vertices; ++v)
    if (!(body.body[v].most >= 0 && body.body[v].most <= 1e30F) ||
        body.body[v].unit_J != static_cast<float>(unit_energy(asset, v)))
      return false;
  return true;
}

/// Largest energy that a place of a body has stored (M55).
struct DamageHistory {
  double unit_J = 0, most_J = 0;
};
inline DamageHistory damage_history_at(const AssetView& asset, int triangle,
                                       const double weight[3]) noexcept {
  double unit = 0, most = 0;
  for (int k = 0; k < 3; ++k) {
    const DamagedVertex& v = asset.body[asset.corner(triangle, k)];
    unit += weight[k] * double(v.unit_J);
    most += weight[k] * double(v.most);
  }
  return {unit, unit * most};
}

/// Triangles that a walk has come to, in a table that stays less than half full.
class VisitedTriangles {
 public:
  VisitedTriangles() noexcept {
    for (int& t : slot_) t = -1;
  }
  /// Returns true if it is new.
  bool add(int triangle) noexcept {
    unsigned i = static_cast<unsigned>(triangle) * 2654435761u >> 24;
    for (; slot_[i] >= 0; i = (i + 1) % kSlots)
      if (slot_[i] == triangle) return false;
    slot_[i] = triangle;
    return true;
  }

 private:
  static constexpr unsigned kSlots = 256;
  static_assert(kSlots > 2 * kMaxDamagedTriangles, "there is a free slot");
  int slot_[kSlots];
};

/// Share of a contact's energy that counts at a squared distance from it, over that of its reach
/// (M57).
inline double damage_kernel(double squared) noexcept {
  const double left = 1 - squared;
  return left > 0 ? left * left : 0;
}

/// Raises M at a place and around it to law_J, the energy of a contact there at this depth; around
/// it less by distance (M57). Nothing heals.
inline void damage(const AssetView& asset, int triangle, const double weight[3], double depth_m,
                   double law_J, double unit_J) noexcept {
  Vec3d corner[3], c{0, 0, 0};
  for (int k = 0; k < 3; ++k) {
    corner[k] = asset.vertex_at(asset.corner(triangle, k));
    c = c + corner[k] * weight[k];
  }
  double squared = asset.damage.reach_m * asset.damage.reach_m * (depth_m / asset.max_fitted_m);
  for (int k = 0; k < 3; ++k) {
    const Vec3d edge = corner[(k + 1) % 3] - corner[k];
    const double least = kMinDamageReach * kMinDamageReach * dot(edge, edge);
    squared = squared > least ? squared : least;
  }
  const double per = 1 / squared;
  // The loading that makes M = E here: corners with a larger one keep it.
  double share[3], most = 0;
  bool is_raised[3] = {true, true, true};
  for (int k = 0; k < 3; ++k) share[k] = damage_kernel(dot(corner[k] - c, corner[k] - c) * per);
  for (int round = 0; round < 3; ++round) {
    double wanted = law_J / unit_J, sum = 0;
    for (int k = 0; k < 3; ++k) {
      if (is_raised[k])
        sum += weight[k] * share[k];
      else
        wanted -= weight[k] * double(asset.body[asset.corner(triangle, k)].most);
    }
    if (!(sum > 0)) return;
    most = wanted / sum;
    for (int k = 0; k < 3; ++k)
      is_raised[k] =
          is_raised[k] && double(asset.body[asset.corner(triangle, k)].most) < most * share[k];
  }
  int found[kMaxDamagedTriangles], count = 1;
  VisitedTriangles visited;
  found[0] = triangle;
  visited.add(triangle);
  for (int i = 0; i < count; ++i) {
    bool is_in[3];
    for (int k = 0; k < 3; ++k) {
      const int v = asset.corner(found[i], k);
      const Vec3d away = asset.vertex_at(v) - c;
      const double part = damage_kernel(dot(away, away) * per);
      is_in[k] = part > 0;
      const float now = static_cast<float>(most * part * kRoundUp);
      if (now > asset.body[v].most) asset.body[v].most = now;
    }
    for (int k = 0; k < 3; ++k) {
      const int next = asset.neighbour[3 * found[i] + k];
      if (next < 0 || !(is_in[k] || is_in[(k + 1) % 3]) || count == kMaxDamagedTriangles) continue;
      if (visited.add(next)) found[count++] = next;
    }
  }
}

/// Softening as a memory of the body (memories.hpp).
struct SofteningMemory {
  static constexpr bool kFlows = false;
  static bool is_any(const AssetView& asset) noexcept { return asset.body != nullptr; }

  /// Psi of what the law stores at a place (M56).
  static MemoryEnergy energy(const AssetView& asset, const ContactPoint& at,
                             double law_J) noexcept {
    const DamageHistory here = damage_history_at(asset, at.triangle, at.weight);
    return softened(asset.damage, here.unit_J, here.most_J, law_J);
  }
  /// Raises M of the place to law_J, reached at depth_m; returns energy() of it from now on.
  static MemoryEnergy load(const AssetView& asset, ContactPoint& at, double depth_m,
                           double law_J) noexcept {
    DamageHistory here = damage_history_at(asset, at.triangle, at.weight);
    const double loaded_J = here.most_J + kDamageStep * (asset.damage.scale * here.unit_J +
                                                         asset.damage.beta * here.most_J);
    const double most_J = law_J > at.pending_J ? law_J : at.pending_J;
    if (most_J > here.most_J && here.unit_J > 0 && depth_m > 0) {
      if (most_J > loaded_J || law_J < most_J) {
        damage(asset, at.triangle, at.weight, depth_m, most_J, here.unit_J);
        here.most_J = most_J;  // as the vertices now say, but for their rounding
        at.pending_J = 0;
      } else {
        at.pending_J = most_J;
      }
    }
    return softened(asset.damage, here.unit_J, here.most_J, law_J);
  }
  /// Nothing heals with time.
  template <class F, class Kinematics, class Memory>
  static void flow(const AssetView&, ContactPoint&, const Kinematics&, const Decay&,
                   Memory&) noexcept {}
};

}  // namespace palpate::runtime
