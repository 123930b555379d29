// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The table of curve families, and the law of the one that a body has. A family is a struct in a
// header of its own that satisfies the concept CurveFamily. To add one: the header, its number and
// its row below.

#if defined(__cpp_concepts)
#include <concepts>
#include <utility>
#endif

#include "rings.hpp"
#include "separable.hpp"

namespace palpate::runtime {

/// Numbers of the rows of the table; assets store them.
enum class Family : int { separable = 0, rings = 1 };

#if defined(__cpp_concepts)  // the engine is C++17 for those who copy it
/// The spot at which the concept asks for a family's functions.
struct FamilySpot {
  Vec3d point, normal;
  double control(int part, int j) const noexcept;
};
template <class F>
using MemoryOf = typename F::template Memory<double>;
template <class F>
using KinematicsOf =
    decltype(F::kinematics(std::declval<const CurveViews&>(), std::declval<const FamilySpot&>(),
                           std::declval<const Vec3d&>(), std::declval<const MemoryOf<F>&>()));

/// A family has constants (its name, its parts, the first kCurves of which are rising curves) and
/// internal variables, which it loads from and saves to kMemory doubles of a contact.
template <class F>
concept FamilyTableRow = requires(const RelaxationView& relaxation, const MemoryOf<F>& memory,
                                  const double* from, double* to) {
  requires F::kCurves >= 1 && F::kMemory >= 0 && F::kSwayPart >= -1;
  { F::kName } -> std::convertible_to<const char*>;
  { F::kPart[0] } -> std::same_as<const Part&>;
  { F::numbers(relaxation) } -> std::same_as<int>;
  { F::template load<double>(from, relaxation) } -> std::same_as<MemoryOf<F>>;
  F::save(memory, to, relaxation);
};
/// Its friction: the excess over the limit, which a slide of the contact point brings to zero, and
/// an anchor that stays behind where the contact point cannot follow.
template <class F>
concept FamilyFriction = requires(const CurveViews& views, const FamilySpot& spot, const Vec3d& x,
                                  KinematicsOf<F>& at, MemoryOf<F>& memory) {
  { F::kIsSmooth } -> std::convertible_to<bool>;
  { F::is_frictionless(views, spot) } -> std::same_as<bool>;
  { F::is_slipping(views, at) } -> std::same_as<bool>;
  { F::slide_target(at) } -> std::same_as<SlideTarget<double>>;
  { F::current_excess(views, at, F::excess_kind(views, at)) } -> std::same_as<double>;
  { F::excess_scale(views, at, F::excess_kind(views, at)) } -> std::same_as<double>;
  { F::excess(views, spot, x, F::excess_kind(views, at)) } -> std::same_as<double>;
  { F::lateral_m(views, spot, x) } -> std::same_as<double>;
  { F::has_anchor_offset(memory) } -> std::same_as<bool>;
  { F::anchor_offset(memory) } -> std::same_as<Vec3d>;
  F::transport(views, memory, x, x);
  F::transport_anchor(memory, x, x, true);
  F::slip_anchor(views, at, memory);
};
/// Its law: force and stored energy, the one the gradient of the other, with internal variables
/// that hold (stick) or follow (slip).
template <class F>
concept CurveFamily = FamilyTableRow<F> && FamilyFriction<F> &&
    requires(const CurveViews& views, const KinematicsOf<F>& at, MemoryOf<F>& memory) {
  { at.d.normal_m + at.d.lateral_m } -> std::same_as<double>;
  { F::slip(views, F::bed(views, at), at, memory).dissipated_J } -> std::same_as<double&&>;
  { F::stored_J(views, F::bed(views, at), at, memory) } -> std::same_as<double>;
  {
    F::answer(views, F::bed(views, at), at, F::stick(views, F::bed(views, at), at, memory))
    } -> std::same_as<Answer<double>>;
};
static_assert(CurveFamily<Separable> && CurveFamily<Rings>);
#endif

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

/// Fills the tables that the law of the body's family reads beside the bases themselves.
inline void prepare(CurveViews& views) noexcept {
  const SplineView& normal = views.view[kNormal];
  views.rings = ring_table(normal, normal.knots[normal.pieces]);
}

}  // namespace palpate::runtime
