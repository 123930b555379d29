// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The memories of a body, as a table; the concept BodyMemory states what each of them has. To add
// one: its header, its block in the asset (asset/format.hpp, asset/check.hpp), and its row here.

#include "body.hpp"

namespace palpate::runtime {

/// A body's Prony series: dashpots of the rings, whose law has their energy in E.
struct RelaxationMemory {
  static constexpr bool kFlows = true;
  static bool is_any(const AssetView& asset) noexcept {
    return asset.curves.relaxation.branches > 0;
  }
  static MemoryEnergy energy(const AssetView&, const ContactPoint&, double law_J) noexcept {
    return {law_J, 1, 0};
  }
  static MemoryEnergy load(const AssetView&, ContactPoint&, double, double law_J) noexcept {
    return {law_J, 1, 0};
  }
  template <class F, class Kinematics, class Memory>
  static void flow(const AssetView& asset, ContactPoint&, const Kinematics& kinematics,
                   const Decay& left, Memory& memory) noexcept {
    if constexpr (F::kCanRelax) F::relax(asset.curves, kinematics, left, memory);
  }
};

#if defined(__cpp_concepts)
/// A memory maps the energy E of the law to the energy that the contact stores and its slopes:
/// energy() at a fixed history, load() once the contact has come to rest at E, flow() over half of
/// a tick's time while the tool rests.
template <class M>
concept BodyMemory = requires(const AssetView& asset, ContactPoint& at, double depth_m, double E,
                              const KinematicsOf<Rings>& kinematics, MemoryOf<Rings>& rings) {
  { M::kFlows } -> std::convertible_to<bool>;
  { M::is_any(asset) } -> std::same_as<bool>;
  { M::energy(asset, at, E) } -> std::same_as<MemoryEnergy>;
  { M::load(asset, at, depth_m, E) } -> std::same_as<MemoryEnergy>;
  M::template flow<Rings>(asset, at, kinematics, Decay(), rings);
};
static_assert(BodyMemory<RelaxationMemory> && BodyMemory<SofteningMemory>);
#endif

template <class... Each>
struct MemoryList {};
using Memories = MemoryList<RelaxationMemory, SofteningMemory>;

template <class... Each>
bool has_memory(const AssetView& asset, MemoryList<Each...>) noexcept {
  return (Each::is_any(asset) || ...);
}

/// Returns true if time changes the memories of this body.
template <class... Each>
bool has_flow(const AssetView& asset, MemoryList<Each...>) noexcept {
  return ((Each::kFlows && Each::is_any(asset)) || ...);
}

/// Psi_2(Psi_1(E)) and its slopes.
inline MemoryEnergy chain(const MemoryEnergy& inner, const MemoryEnergy& outer) noexcept {
  return {outer.stored_J, outer.share * inner.share,
          outer.slope * (inner.share * inner.share) + outer.share * inner.slope};
}

/// Energy that a contact stores if the law stores law_J, by all memories in turn.
template <class... Each>
MemoryEnergy stored_in(const AssetView& asset, const ContactPoint& at, double law_J,
                       MemoryList<Each...>) noexcept {
  MemoryEnergy out{law_J, 1, 0};
  const auto take = [&](auto memory) noexcept {
    using Memory = decltype(memory);
    if (Memory::is_any(asset)) out = chain(out, Memory::energy(asset, at, out.stored_J));
  };
  (take(Each()), ...);
  return out;
}

/// The same once the body has kept what it keeps.
template <class... Each>
MemoryEnergy load(const AssetView& asset, ContactPoint& at, double depth_m, double law_J,
                  MemoryList<Each...>) noexcept {
  MemoryEnergy out{law_J, 1, 0};
  const auto take = [&](auto memory) noexcept {
    using Memory = decltype(memory);
    if (Memory::is_any(asset)) out = chain(out, Memory::load(asset, at, depth_m, out.stored_J));
  };
  (take(Each()), ...);
  return out;
}

/// Half of a tick's time passes on all memories.
template <class F, class Kinematics, class Memory, class... Each>
void flow(const AssetView& asset, ContactPoint& at, const Kinematics& kinematics, const Decay& left,
          Memory& memory, MemoryList<Each...>) noexcept {
  ((Each::kFlows && Each::is_any(asset)
        ? Each::template flow<F>(asset, at, kinematics, left, memory)
        : void()),
   ...);
}

}  // namespace palpate::runtime
