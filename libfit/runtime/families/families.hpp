// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The table of curve families, and the law of the one that a body has. A family is a struct in a
// header of its own:
//   kName, kPart    its name and what a node owns; normal, lateral and limit curve come first
//   kMemory         doubles that a contact remembers beside its place (Contact::memory)
//   deflection, force, energy_J, slide   its law, templates over the scalar and the Spot
// To add one: the header, its number and its row below.

#include "leaning.hpp"
#include "separable.hpp"

namespace palpate {
namespace runtime {

/// Numbers of the rows of the table; assets store them.
enum class Family : int { separable = 0, leaning = 1 };

template <class... Each>
struct FamilyList {};
using Families = FamilyList<Separable, Leaning>;

struct FamilyRow {
  const char* name;
  const Part* part;
  int parts;
  int memory;
};
template <class... Each>
struct FamilyTable {
  static constexpr int kCount = sizeof...(Each);
  static constexpr FamilyRow kRow[] = {
      {Each::kName, Each::kPart, int(sizeof(Each::kPart) / sizeof(Part)), Each::kMemory}...};
  static constexpr int max_memory() noexcept {
    int most = 1;  // an array has a length
    for (const FamilyRow& row : kRow) most = row.memory > most ? row.memory : most;
    return most;
  }
  static constexpr bool fits_an_asset() noexcept {
    for (const FamilyRow& row : kRow)
      if (row.parts < kCurves || row.parts > kMaxParts) return false;
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

/// The deflection of a tool at x [m] whose contact point is the spot.
template <class T, class Spot>
Deflection<T> deflection(const CurveViews& views, const Spot& spot, const Vec3<T>& x) noexcept {
  return with_family(views, [&](auto f) noexcept { return f.deflection(views, spot, x); });
}

template <class T, class Spot>
Footing<T, Spot> footing(const CurveViews& views, const Spot& spot, const Vec3<T>& x) noexcept {
  return with_family(views,
                     [&](auto f) noexcept { return footing_as<decltype(f)>(views, spot, x); });
}

/// Force of the tool on the body [N], the gradient of the stored energy. lateral_N: f^r.
template <class T, class Spot>
Vec3<T> response(const CurveViews& views, const Spot& spot, const Deflection<T>& d,
                 const T& lateral_N) noexcept {
  return with_family(views, [&](auto f) noexcept { return f.force(views, spot, d, lateral_N); });
}
template <class T, class Spot>
Vec3<T> response(const CurveViews& views, const Spot& spot, const Deflection<T>& d) noexcept {
  return response(views, spot, d, lateral_force(views, spot, d));
}

/// Stored energy of a spot [J] at a deflection: the corners' curve energies blended.
template <class Spot>
double stored_energy_J(const CurveViews& views, const Spot& spot,
                       const Deflection<double>& d) noexcept {
  return with_family(views, [&](auto f) noexcept { return f.energy_J(views, spot, d); });
}

/// Lets the contact point slide until it holds the tool at x [m]: slide_until_it_holds() of
/// slide.hpp or the family's own way.
template <class T, class Surface, class Spot>
SlideEnd slide(const CurveViews& views, const Vec3<T>& x, Surface& surface,
               Footing<T, Spot>& foot) noexcept {
  return with_family(views, [&](auto f) noexcept { return f.slide(views, x, surface, foot); });
}
template <class T, class Surface>
SlideEnd slide(const CurveViews& views, const Vec3<T>& x, Surface& surface) noexcept {
  auto foot = footing(views, surface.standing(), x);
  return slide(views, x, surface, foot);
}

}  // namespace runtime
}  // namespace palpate
