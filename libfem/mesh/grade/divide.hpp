#pragma once

#include <functional>
#include <limits>

#include "libfem/mesh/grade/smooth_surface.hpp"

namespace palpate::fem {

/// When a triangle is too large [m]. longest_m: an edge is longer. sagitta_m: the smooth surface is
/// farther from the middle of an edge, and the longest edge is longer than shortest_m.
struct DivisionLimits {
  double longest_m = std::numeric_limits<double>::infinity();
  double sagitta_m = std::numeric_limits<double>::infinity();
  double shortest_m = 0;
};

/// True where a triangle with these corners [m], a part of triangle `of` of the surface, is to
/// be divided where it is too large.
using IsDivided = std::function<bool(std::int32_t of, const Vec3& a, const Vec3& b, const Vec3& c)>;

/// The surface with its triangles divided until none that is_divided is too large. New vertices lie
/// on the smooth surface, on a crease in the middle of what its two sides say; what is flat keeps
/// its shape but for rounding. A surface that is closed and manifold stays so: an edge is cut for
/// both its triangles. Vertices keep their numbers, new ones come after them. In the plane angles
/// stay above about half of the smallest there is (the longest edge is cut, and those of neighbours
/// before it). Source: Rivara 1984, doi:10.1002/nme.1620200412.
Surface divided(const SmoothSurface& surface, const IsDivided& is_divided,
                const DivisionLimits& limits);

/// The same within radius_m [m] of `centre`, by the length of edges. Throws Error as SmoothSurface
/// does.
Surface divided_near(const Surface& surface, const Vec3& centre, double radius_m, double longest_m);

}  // namespace palpate::fem
