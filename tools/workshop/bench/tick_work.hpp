#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "tests/support/bodies.hpp"

namespace palpate::tools {

/// A kind of tick, with the way that brings it, over bench_cylinder.
struct TickKind {
  std::string_view name;
  Vec3 (*tip)(long tick);  ///< [m]; ticks from 0 on, each a millisecond
};
/// press: up and down in contact; stick: a small circle under the friction limit; slip: 50 mm/s
/// around; touch: in the air within a millimetre of the surface.
inline constexpr std::size_t kTickKinds = 4;
extern const std::array<TickKind, kTickKinds> kTicksOfKind;

/// Distinct 64-byte lines that one stick or slip tick at the contact cannot do without: its
/// corners' places, normals and controls, the triangle, and the tables' knots and one interval per
/// curve.
std::vector<const unsigned char*> lines_of_a_tick(const runtime::AssetView& asset,
                                                  const runtime::Contact& contact);

}  // namespace palpate::tools
