// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The table of curve families, and the law of the one that a body has. A family is a struct in a
// header of its own; docs/extending.md says what it brings. To add one: the header, its number and
// its row below.

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
  views.rings = ring_table(normal, normal.knots[normal.pieces]);
}

}  // namespace runtime
}  // namespace palpate
