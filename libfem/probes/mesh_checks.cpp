#include "libfem/probes/mesh_field.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"

namespace palpate::fem {
namespace {

struct DirectedSide {
  std::int32_t low, high, side;
  bool is_forward;  // runs from low to high
};

std::vector<DirectedSide> sorted_sides(const Triangles& triangles) {
  std::vector<DirectedSide> sides;
  for (std::int32_t f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = triangles(f, k), b = triangles(f, (k + 1) % 3);
      sides.push_back({std::min(a, b), std::max(a, b), 3 * f + k, a < b});
    }
  std::sort(sides.begin(), sides.end(), [](const DirectedSide& x, const DirectedSide& y) {
    return std::tie(x.low, x.high, x.side) < std::tie(y.low, y.high, y.side);
  });
  return sides;
}

/// Calls use(begin, end) with the sides of each edge.
template <class Use>
void for_each_edge(const std::vector<DirectedSide>& sides, const Use& use) {
  for (auto begin = sides.begin(); begin != sides.end();) {
    auto end = begin + 1;
    while (end != sides.end() && end->low == begin->low && end->high == begin->high) ++end;
    use(begin, end);
    begin = end;
  }
}

void check_edges(const Triangles& triangles, const std::string& where) {
  std::int64_t open = 0, crowded = 0, unlike = 0;
  std::int32_t first = -1;
  for_each_edge(sorted_sides(triangles), [&](auto begin, auto end) {
    const auto sides = end - begin;
    const bool is_open = sides == 1, is_crowded = sides > 2;
    const bool is_unlike = sides == 2 && begin->is_forward == (begin + 1)->is_forward;
    open += is_open;
    crowded += is_crowded;
    unlike += is_unlike;
    if ((is_open || is_crowded || is_unlike) && first < 0) first = begin->side / 3 + 1;
  });
  const std::string at = ", the first at triangle " + std::to_string(first);
  if (open)
    throw Error(
        where,
        "the probe's mesh is open: " + counted(open, "edge has", "edges have") + " one triangle" +
            at,
        "Close it, for example with a mesh editor's \"fill holes\"; a probe needs an inside.");
  if (crowded)
    throw Error(where,
                "the probe's mesh is not manifold: " + counted(crowded, "edge has", "edges have") +
                    " more than two triangles" + at,
                "Remove walls inside it, or unite its parts into one solid.");
  if (unlike)
    throw Error(where,
                "triangles of the probe's mesh disagree about its outside at " +
                    counted(unlike, "edge", "edges") + at,
                "Make its normals consistent and export it again.");
}

/// Every vertex of a closed mesh has as many triangles in one fan as in all.
void check_fans(const Triangles& triangles, const std::string& where) {
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> side_of;  // from, to
  std::map<std::int32_t, std::int64_t> use;
  std::map<std::int32_t, std::int32_t> some_side;  // starting at the vertex
  for (std::int32_t f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      side_of[{triangles(f, k), triangles(f, (k + 1) % 3)}] = 3 * f + k;
      some_side[triangles(f, k)] = 3 * f + k;
      ++use[triangles(f, k)];
    }
  for (const auto& [vertex, start] : some_side) {
    std::int64_t fan = 0;
    std::int32_t side = start;
    do {
      ++fan;
      const std::int32_t f = side / 3, k = side % 3;
      side = side_of[{vertex, triangles(f, (k + 2) % 3)}];  // across the side that ends here
    } while (side != start && fan <= use[vertex]);
    if (fan != use[vertex])
      throw Error(where,
                  "the probe's mesh is not manifold: several sheets meet at vertex " +
                      std::to_string(vertex + 1),
                  "Separate or unite the parts that touch in one point.");
  }
}

}  // namespace

std::vector<EdgePair> edge_pairs(const Triangles& triangles) {
  std::vector<EdgePair> pairs;
  for_each_edge(sorted_sides(triangles), [&](auto begin, auto) {
    pairs.push_back({{begin->side, (begin + 1)->side}});
  });
  return pairs;
}

void check_probe_mesh(const Surface& surface, const std::string& where) {
  const Triangles& triangles = surface.triangles;
  if (triangles.rows() == 0)
    throw Error(where, "the probe's mesh has no triangle", "Name a closed triangle mesh.");
  if (triangles.minCoeff() < 0 || triangles.maxCoeff() >= surface.vertices.rows() ||
      !surface.vertices.allFinite())
    throw Error(where,
                "a triangle of the probe's mesh names a vertex that is not there, or not finite",
                "Repair the mesh.");
  const double extent = extent_m(surface.vertices).maxCoeff();
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    const auto corner = [&](int k) { return Vec3(surface.vertices.row(triangles(f, k))); };
    if (!((corner(1) - corner(0)).cross(corner(2) - corner(0)).norm() > 1e-14 * extent * extent))
      throw Error(
          where, "triangle " + std::to_string(f + 1) + " of the probe's mesh has no area",
          "Remove triangles without area, for example with a mesh editor's \"merge vertices\".");
  }
  check_edges(triangles, where);
  check_fans(triangles, where);
  if (!(volume_m3(surface) > 0))
    throw Error(where, "the probe's mesh is inside out", "Turn its triangles around.");
}

}  // namespace palpate::fem
