#pragma once

#include <string>

#include "libfit/core/geometry.hpp"

namespace palpate::tools {

/// The surface with its triangles divided until none that comes within radius_m of `centre` has an
/// edge longer than longest_m > 0. The shape stays to the last bit but for rounding of midpoints,
/// and a surface that is closed and manifold stays so: an edge is cut for both its triangles.
/// Angles stay above about half of the smallest there is (the longest edge is cut, and those of
/// neighbours before it). Source: Rivara 1984, doi:10.1002/nme.1620200412.
Surface divided_near(const Surface& surface, const Vec3& centre, double radius_m, double longest_m);

/// The text of an OFF file in metres that reads back as the same doubles.
std::string off_text(const Surface& surface);

}  // namespace palpate::tools
