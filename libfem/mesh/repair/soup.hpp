#pragma once

#include <string>
#include <vector>

#include "libfem/mesh/topology.hpp"
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

}  // namespace palpate::repair
