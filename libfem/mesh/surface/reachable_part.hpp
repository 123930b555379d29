#pragma once

#include <cstdint>
#include <vector>

#include "libfit/core/geometry.hpp"

namespace palpate {

/// The part of a surface that a tool can touch, on its own.
struct ReachablePart {
  Surface surface;  ///< vertices in the order of the whole surface, unused ones left out
  Points normals;   ///< per vertex of `surface`, outward unit, of the WHOLE surface
  std::vector<std::int32_t> vertex;  ///< of the whole surface, per vertex of `surface`
};

/// Triangles whose three vertices are reachable, without those that would make a vertex join two
/// sheets (the largest sheet at the vertex stays). Throws Error when no triangle is left or an
/// index is out of range.
ReachablePart reachable_part(const Surface& fine, const std::vector<char>& is_reachable);

}  // namespace palpate
