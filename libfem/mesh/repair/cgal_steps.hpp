#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "libfit/core/geometry.hpp"

/// The steps that CGAL makes. All but the last need a surface whose edges have at
/// most two triangles that agree, and whose vertices have one fan (surface_facts: is_manifold and
/// is_oriented): CGAL crashes or loops on others. Each checks that and throws Error otherwise.
namespace palpate::repair {

/// Pairs of triangles that cross or touch other than along what they share; in order.
std::vector<std::pair<std::size_t, std::size_t>> self_intersections(const Surface& surface);

/// The triangles of these pairs, with all vertices.
Surface crossing_part(const Surface& surface);

/// The surface with triangles around its self-intersections replaced; none when that failed.
/// Source: CGAL 5.5, remove_self_intersections (smoothing, then hole filling, locally).
std::optional<Surface> without_self_intersections(const Surface& surface);

struct FilledHoles {
  Surface surface;
  std::size_t filled = 0;
  std::size_t triangles = 0;  ///< added
  double widest_m = 0;        ///< diagonal of the widest hole's bounding box
  std::vector<Vec3> left;     ///< a border point of each hole that could not be filled
};

/// Holes closed by triangulations of least area, refined to the size of the triangles around.
/// Holes of more than kLongestHole edges are left: the method's cost is the cube of their number.
/// Source: Liepa 2003, Filling Holes in Meshes, as in CGAL 5.5.
inline constexpr std::size_t kLongestHole = 2000;
FilledHoles fill_holes(const Surface& surface);

/// A closed surface around any triangles, manifold or not. alpha_m: gaps narrower are closed;
/// offset_m: distance outside. Source: CGAL 5.5, 3D Alpha Wrapping (Portaneri et al. 2022,
/// doi:10.1145/3528223.3530152).
Surface wrap_surface(const Surface& surface, double alpha_m, double offset_m);

}  // namespace palpate::repair
