// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The memories of a body, as a table; docs/extending.md says what each of them brings. To add one:
// its header, its block in the asset (asset/format.hpp, asset/check.hpp), and its row here.

#include "body.hpp"

namespace palpate {
namespace runtime {

/// A body's Prony series: dashpots of the rings, whose law has their energy in E.
struct RelaxationMemory {
  static constexpr bool kFlows = true;
  static bool is_any(const AssetView& asset) noexcept {
    return asset.curves.relaxation.branches > 0;
  }
  static Softened energy(const AssetView&, const ContactPoint&, double law_J) noexcept {
    return {law_J, 1, 0};
  }
  static Softened load(const AssetView&, ContactPoint&, double, double law_J) noexcept {
    return {law_J, 1, 0};
  }
  template <class F, class Kinematics, class Memory>
  static void flow(const AssetView& asset, ContactPoint&, const Kinematics& kinematics,
                   const Decay& left, Memory& memory) noexcept {
    if constexpr (F::kCanRelax) F::relax(asset.curves, kinematics, left, memory);
  }
};

template <class... Each>
struct MemoryList {};
using Memories = MemoryList<RelaxationMemory, SofteningMemory>;

template <class... Each>
bool has_memory(const AssetView& asset, MemoryList<Each...>) noexcept {
  return (Each::is_any(asset) || ...);
}

/// Whether time changes what this body remembers.
template <class... Each>
bool has_flow(const AssetView& asset, MemoryList<Each...>) noexcept {
  return ((Each::kFlows && Each::is_any(asset)) || ...);
}

/// Psi_2(Psi_1(E)) and its slopes.
inline Softened chain(const Softened& inner, const Softened& outer) noexcept {
  return {outer.stored_J, outer.share * inner.share,
          outer.slope * (inner.share * inner.share) + outer.share * inner.slope};
}

/// What a contact stores where the law stores law_J, by all memories in turn.
template <class... Each>
Softened stored_in(const AssetView& asset, const ContactPoint& at, double law_J,
                   MemoryList<Each...>) noexcept {
  Softened out{law_J, 1, 0};
  const auto take = [&](auto memory) noexcept {
    using Memory = decltype(memory);
    if (Memory::is_any(asset)) out = chain(out, Memory::energy(asset, at, out.stored_J));
  };
  (take(Each()), ...);
  return out;
}

/// The same once the body has kept what it keeps.
template <class... Each>
Softened load(const AssetView& asset, ContactPoint& at, double depth_m, double law_J,
              MemoryList<Each...>) noexcept {
  Softened out{law_J, 1, 0};
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

}  // namespace runtime
}  // namespace palpate
