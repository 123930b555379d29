#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libfem/mesh/topology.hpp"
#include "libfit/core/geometry.hpp"
#include "libfit/core/text.hpp"

namespace palpate::repair {

/// Triangles that become a surface. origin: the input's triangle that each came from.
/// is_turned: oriented against it.
struct Soup {
  std::vector<Vec3> points;
  std::vector<Triangle> faces;
  std::vector<std::int32_t> origin;
  std::vector<char> is_turned;
};

using Changes = std::vector<std::string>;

Soup to_soup(const Surface& surface);
Surface to_surface(const Soup& soup);

/// Keeps the faces for which keep[f] != 0, and returns how many that dropped.
std::size_t keep_faces(Soup& soup, const std::vector<char>& keep);

/// Each of these makes one kind of repair and adds a sentence to `changes` if it did anything.
/// CGAL's own repair of polygon soups merges points of equal bits alone and leaves copies of a
/// vertex where they lie: a scan with holes (65 such vertices) then crosses itself when they are
/// filled.
void weld_vertices(Soup& soup, double weld_m, Changes& changes);
void drop_flat_faces(Soup& soup, double weld_m, Changes& changes);
void drop_duplicate_faces(Soup& soup, Changes& changes);
/// Splits border triangles where a border vertex lies within weld_m of their edge.
void split_t_junctions(Soup& soup, double weld_m, Changes& changes);
void drop_stray_components(Soup& soup, double smallest_share, Changes& changes);
void drop_unused_vertices(Soup& soup);

/// Glues triangles into sheets that are manifold and oriented, keeping the input's orientation of
/// most triangles of each. At an edge of more than two triangles, neighbours with the body between
/// them are glued if the input's orientation shows where it is, else none. Vertices are copied so
/// that each has one fan; copies are moved apart by 1e-3 of their shortest edge.
/// Throws Error when a sheet is one-sided.
void make_manifold(Soup& soup, Changes& changes, const std::string& where);

/// Drops sheets with an open border, apart or on an edge of more than two triangles, where the rest
/// is closed without them and no lid makes a body of them. Before make_manifold, whose errors it
/// throws.
void drop_stray_facets(Soup& soup, Changes& changes, const std::string& where);

/// Turns whole components outward, and cavities inward: those inside the body that point against
/// its outer surface. Drops those inside that point as it does. Counts also what make_manifold
/// turned.
void orient_outward(Soup& soup, Changes& changes);

/// Up to six triangles, numbered from 1 as in the input.
std::string name_faces(const Soup& soup, const std::vector<std::int32_t>& faces);

// The steps that CGAL makes. All but the last need a surface whose edges have at
// most two triangles that agree, and whose vertices have one fan (surface_facts: is_manifold and
// is_oriented): CGAL crashes or loops on others. Each checks that and throws Error otherwise.

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
/// offset_m: distance outside. seeds: places from which it is carved instead, in hollows that the
/// surface is then wrapped from; its triangles look into them. Source: CGAL 5.5, 3D Alpha Wrapping
/// (Portaneri et al. 2022, doi:10.1145/3528223.3530152).
Surface wrap_surface(const Surface& surface, double alpha_m, double offset_m,
                     const std::vector<Vec3>& seeds = {});

}  // namespace palpate::repair
