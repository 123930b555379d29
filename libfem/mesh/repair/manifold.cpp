#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "libfem/mesh/repair/repair_steps.hpp"
#include "libfit/core/error.hpp"

namespace palpate::repair {
namespace {

// Copies of a vertex are moved apart by this share of their shortest edge: far above what exact
// predicates and the mesher's tolerance (1e-8) confuse, far below what a probe can sense.
constexpr double kApart = 1e-3;

struct Glue {
  TriangleSide a, b;
};

// Angle of a face about the edge low-high, from an arbitrary but common direction.
double angle_about_edge(const Soup& soup, const TriangleSide& side) {
  const Vec3 low = soup.points[side.low];
  const Vec3 axis = (soup.points[side.high] - low).normalized();
  const Triangle& face = soup.faces[side.face];
  const std::int32_t apex = face[(side.corner + 2) % 3];
  const Vec3 x = axis.unitOrthogonal(), y = axis.cross(x), to_apex = soup.points[apex] - low;
  return std::atan2(to_apex.dot(y), to_apex.dot(x));
}

// Pairs the faces of a crowded edge across the body between them. Turning about low -> high, the
// body begins at a face that runs backward (its outward normal points against the turn) and ends
// at the next, which must run forward; where that does not alternate, nothing is glued.
std::vector<Glue> pair_around_edge(const Soup& soup, std::vector<TriangleSide> sides) {
  std::ranges::sort(sides, [&](const TriangleSide& a, const TriangleSide& b) {
    return std::pair(angle_about_edge(soup, a), a.face) <
           std::pair(angle_about_edge(soup, b), b.face);
  });
  std::vector<Glue> glues;
  const std::size_t n = sides.size();
  for (std::size_t i = 0; i < n; ++i) {
    const TriangleSide &here = sides[i], &next = sides[(i + 1) % n];
    if (here.is_forward == next.is_forward) return {};
    if (!here.is_forward) glues.push_back({here, next});
  }
  return glues;
}

struct Neighbour {
  std::int32_t face;
  bool is_unlike;  // runs along the shared edge in the same direction
};

// Turns faces so that neighbours agree, keeping the orientation of most faces of each sheet.
void agree_on_sides(Soup& soup, const std::vector<Glue>& glues, const std::string& where) {
  std::vector<std::vector<Neighbour>> next_to(soup.faces.size());
  for (const Glue& g : glues) {
    const bool is_unlike = g.a.is_forward == g.b.is_forward;
    next_to[g.a.face].push_back({g.b.face, is_unlike});
    next_to[g.b.face].push_back({g.a.face, is_unlike});
  }
  std::vector<signed char> turn(soup.faces.size(), -1);
  for (std::size_t first = 0; first < turn.size(); ++first) {
    if (turn[first] >= 0) continue;
    turn[first] = 0;
    std::vector<std::int32_t> sheet{static_cast<std::int32_t>(first)};
    std::size_t turned = 0;
    for (std::size_t i = 0; i < sheet.size(); ++i)
      for (const Neighbour& n : next_to[sheet[i]]) {
        const auto wanted =
            static_cast<signed char>(turn[sheet[i]] ^ static_cast<int>(n.is_unlike));
        if (turn[n.face] < 0) {
          turn[n.face] = wanted;
          turned += wanted;
          sheet.push_back(n.face);
        } else if (turn[n.face] != wanted) {
          throw Error(where,
                      "the surface has only one side (a Moebius strip) at " +
                          name_faces(soup, {sheet[i], n.face}) + ", near " +
                          coordinates(soup.points[soup.faces[n.face][0]]),
                      "Remove inner sheets in a mesh editor, or wrap it.");
        }
      }
    if (2 * turned > sheet.size())
      for (const std::int32_t f : sheet) turn[f] ^= 1;
  }
  for (std::size_t f = 0; f < turn.size(); ++f)
    if (turn[f] == 1) {
      std::swap(soup.faces[f][1], soup.faces[f][2]);
      soup.is_turned[f] ^= 1;
    }
}

// Copies each vertex until its faces form one fan. Returns the copies of each vertex that has some.
std::vector<std::vector<std::int32_t>> split_fans(Soup& soup, const std::vector<Glue>& glues) {
  DisjointSets corners(3 * soup.faces.size());
  for (const Glue& g : glues) join_fans(rows_of(soup.faces), g.a, g.b, corners);

  std::vector<std::vector<std::int32_t>> copies(soup.points.size());
  std::vector<std::int32_t> vertex_of(3 * soup.faces.size());
  for (std::size_t c = 0; c < 3 * soup.faces.size(); ++c) {
    std::int32_t& v = soup.faces[c / 3][c % 3];
    const std::size_t fan = corners.find(c);
    if (fan == c) {
      std::vector<std::int32_t>& of_vertex = copies[v];
      vertex_of[c] = of_vertex.empty() ? v : static_cast<std::int32_t>(soup.points.size());
      if (!of_vertex.empty()) soup.points.push_back(soup.points[v]);
      of_vertex.push_back(vertex_of[c]);
    }
    v = vertex_of[fan];
  }
  std::erase_if(copies, [](const auto& list) { return list.size() < 2; });
  return copies;
}

// Moves copies towards the middle of their own neighbours.
void move_apart(Soup& soup, const std::vector<std::vector<std::int32_t>>& copies) {
  struct Ring {
    Vec3 sum = Vec3::Zero();
    int number = 0;
    double shortest = std::numeric_limits<double>::infinity();
  };
  std::map<std::int32_t, Ring> rings;
  for (const auto& list : copies)
    for (const std::int32_t v : list) rings[v] = {};
  const std::vector<Vec3> before = soup.points;
  for (const Triangle& face : soup.faces)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto ring = rings.find(face[k]);
      if (ring == rings.end()) continue;
      for (std::size_t other : {face[(k + 1) % 3], face[(k + 2) % 3]}) {
        const Vec3 to = before[other] - before[face[k]];
        ring->second.sum += to;
        ++ring->second.number;
        ring->second.shortest = std::min(ring->second.shortest, to.norm());
      }
    }
  for (const auto& [vertex, ring] : rings) {
    const double length = ring.sum.norm();
    if (length > 0) soup.points[vertex] += kApart * ring.shortest / length * ring.sum;
  }
}

}  // namespace

void make_manifold(Soup& soup, Changes& changes, const std::string& where) {
  std::vector<Glue> glues;
  std::size_t crowded_edges = 0;
  for_each_edge(sorted_sides(rows_of(soup.faces)), [&](auto begin, auto end) {
    if (end - begin == 2) glues.push_back({*begin, *(begin + 1)});
    if (end - begin <= 2) return;
    ++crowded_edges;
    for (const Glue& glue : pair_around_edge(soup, {begin, end})) glues.push_back(glue);
  });
  agree_on_sides(soup, glues, where);
  const auto copies = split_fans(soup, glues);
  move_apart(soup, copies);
  if (crowded_edges > 0)
    changes.push_back("separated sheets at " + counted(crowded_edges, "edge", "edges") +
                      " of more than two triangles");
  if (!copies.empty())
    changes.push_back("separated the surface from itself at " +
                      counted(copies.size(), "vertex", "vertices") + " where it touched, by " +
                      "0.1 % of the shortest edge there");
}

}  // namespace palpate::repair
