// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The table of curve families, and the law of the one that a body has. A family is a struct in a
// header of its own:
//   kName, kPart, kCurves   its name, what a node owns, and how many of these parts, from the first
//                           on, are rising curves; the first is the normal one
//   kSwayPart               which part is the compliance of a sway (compliance.hpp); -1
//   kMemory, numbers, Memory, load, save   what a contact remembers beside its place, as doubles
//                           (Contact::memory) and as the law's scalars
//   kinematics    where a tool stands against its contact point: .spot, .d
//   is_slipping   whether the contact point cannot hold
//   pull, way     where it is drawn, and the path of a slide as the law follows it
//   excess, excess_here, excess_kind, excess_scale, excess_along, lateral_m, kIsSmooth
//                 what its slide brings to zero, at a place and at the kinematics, the pull that
//                 its tolerance is a share of, and whether no knot is in it
//   is_out, rest, carry_rest, let_go   the contact point's anchor: whether and where it lies beside
//                 it, where it lies after a move, and a slip without it
//   carry         what the contact point's way of a whole tick does to the rest of the memory
//   under         what the law reads of a spot beside its curves, made once a tick
//   slip          lets slip what slips while the contact point holds; .lost_J that this dissipated
//   stick         the same without a slip
//   stored_J      what answer() stores without a slip, alone
//   answer        of what one of these two brought: force and stored energy, the one the gradient
//                 of the other
//   is_frictionless
//   kCanRelax     whether it has a memory of time (CurveViews::relaxation); it then brings relaxes,
//                 relax: what rests lets its dashpots flow; seen: where a slide sees the tool
// To add one: the header, its number and its row below.

#include "rings.hpp"
#include "separable.hpp"

namespace palpate {
namespace runtime {

/// Numbers of the rows of the table; assets store them.
enum class Family : int { separable = 0, rings = 1 };

template <class... Each>
struct FamilyList {};
using Families = FamilyList<Separable, Rings>;

struct FamilyRow {
  const char* name;
  const Part* part;
  int parts;
  int curves;
  int memory;
  int sway_part;
};
template <class... Each>
struct FamilyTable {
  static constexpr int kCount = sizeof...(Each);
  static constexpr FamilyRow kRow[] = {{Each::kName, Each::kPart,
                                        int(sizeof(Each::kPart) / sizeof(Part)), Each::kCurves,
                                        Each::kMemory, Each::kSwayPart}...};
  static constexpr int max_memory() noexcept {
    int out = 1;  // an array has a length
    for (const FamilyRow& row : kRow) out = row.memory > out ? row.memory : out;
    return out;
  }
  static constexpr bool fits_an_asset() noexcept {
    for (const FamilyRow& row : kRow)
      if (row.curves < 1 || row.curves > kCurves || row.parts > kMaxParts) return false;
    return true;
  }
};
template <class... Each>
constexpr FamilyTable<Each...> table_of(FamilyList<Each...>) noexcept {
  return {};
}
using FamilyRows = decltype(table_of(Families()));
constexpr int kFamilies = FamilyRows::kCount;
constexpr int kFamilyMemory = FamilyRows::max_memory();
static_assert(FamilyRows::fits_an_asset(), "parts of a family");

constexpr const FamilyRow& row_of(Family family) noexcept {
  return FamilyRows::kRow[static_cast<int>(family)];
}

/// The part of a family that is a sway's compliance; -1: none.
inline int sway_part_of(int family) noexcept {
  return row_of(static_cast<Family>(family)).sway_part;
}

/// The memory of a contact that has just begun.
inline const double* no_memory() noexcept {
  static constexpr double kNone[kFamilyMemory] = {};
  return kNone;
}

/// act(F()) of the family of that number; of the last one if there is none.
template <class Act, class F, class... More>
auto with_family(int family, const Act& act, FamilyList<F, More...>) noexcept {
  if constexpr (sizeof...(More) == 0)
    return act(F());
  else
    return family == 0 ? act(F()) : with_family(family - 1, act, FamilyList<More...>());
}
template <class Act>
auto with_family(const CurveViews& views, const Act& act) noexcept {
  return with_family(views.family, act, Families());
}

/// What the law of the body's family reads beside the bases themselves.
inline void prepare(CurveViews& views) noexcept {
  const SplineView& normal = views.view[kNormal];
  views.rings = ring_table<kRings>(normal, normal.knots[normal.pieces]);
}

}  // namespace runtime
}  // namespace palpate
