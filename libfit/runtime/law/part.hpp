// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// What a node of a curve family owns, part by part: a curve over a basis that the body shares, or
// some numbers. Files, assets, blending and checks loop over the parts of a family and know no
// family by name.

#include "../base/rounding.hpp"

namespace palpate {
namespace runtime {

constexpr int kMaxParts = 10;        ///< of a family: an asset's header has room for as many
constexpr double kMaxNumber = 1e15;  ///< of what a node owns: products of a few stay finite
constexpr double kMaxForce_N = 1e6;  ///< of a curve, and of a tool's cap: no body bears it

/// What of a node is known before any fit.
enum class Known {
  no,
  curvature,  ///< minus the gradient of the inward normal
  sway,       ///< how the body gives as a whole: of no tool, so no force scales it
  tools,      ///< how curves change with the indenter's radius: 0 unless several were pressed
};
struct Part {
  const char* name;     ///< of its columns, such as "normal"
  const char* unit;     ///< of its numbers, SI
  int length, force;    ///< powers of length and force in that unit
  int width;            ///< numbers of a control value: 1; 3: x, y, z; 6: xx, yy, zz, xy, xz, yz
  int count;            ///< control values of a node; 0: a curve, as many as its basis has
  bool starts_at_zero;  ///< the first control value is 0
  bool rises;           ///< no control value is below the one before
  double min, max;      ///< bounds of every number
  Known known = Known::no;  ///< before any fit

  constexpr bool is_curve() const noexcept { return count == 0; }
};

/// A curve of force over depth or deflection that is zero at zero and never falls.
constexpr Part rising_curve(const char* name, double max_N = kMaxForce_N) noexcept {
  return {name, "N", 0, 1, 1, 0, true, true, 0, max_N};
}

/// Whether `controls` control values of a part are admissible numbers; where a node does not
/// answer (is_zero) all of them are 0.
template <class C>
bool is_good_part(const Part& part, const C* control, int controls, bool is_zero) noexcept {
  for (int j = 0; j < controls * part.width; ++j) {
    const double value = double(control[j]);
    const bool must_be_zero = is_zero || (part.starts_at_zero && j < part.width);
    if (must_be_zero ? value != 0 : !(value >= part.min && value <= part.max)) return false;
    if (part.rises && j >= part.width && !(value >= double(control[j - part.width]))) return false;
  }
  return true;
}

}  // namespace runtime
}  // namespace palpate
