#include <algorithm>

#include "libfem/mesh/repair/soup.hpp"

namespace palpate::repair {
namespace {

constexpr int kMaxPasses = 8;  // a triangle can be hit on each side, and its halves again

struct OnEdge {
  double along;
  std::int32_t vertex;
};

std::vector<std::int32_t> border_vertices_by_x(const Soup& soup, const std::vector<Side>& border) {
  std::vector<std::int32_t> vertices;
  for (const Side& side : border) vertices.insert(vertices.end(), {side.low, side.high});
  const auto x_of = [&](std::int32_t v) { return soup.points[static_cast<std::size_t>(v)].x(); };
  std::ranges::sort(vertices, [&](std::int32_t a, std::int32_t b) {
    return std::pair(x_of(a), a) < std::pair(x_of(b), b);
  });
  vertices.erase(std::ranges::unique(vertices).begin(), vertices.end());
  return vertices;
}

// Border vertices on the inside of a side, in the side's direction.
std::vector<OnEdge> vertices_on(const Soup& soup, const Side& side,
                                const std::vector<std::int32_t>& by_x, double weld_m) {
  const auto point = [&](std::int32_t v) -> const Vec3& {
    return soup.points[static_cast<std::size_t>(v)];
  };
  const Triangle& face = soup.faces[static_cast<std::size_t>(side.face)];
  const auto k = static_cast<std::size_t>(side.corner);
  const Vec3 a = point(face[k]), b = point(face[(k + 1) % 3]);
  const double length = (b - a).norm();
  const Vec3 direction = (b - a) / length;
  const auto first = std::ranges::lower_bound(by_x, std::min(a.x(), b.x()) - weld_m, {},
                                              [&](std::int32_t v) { return point(v).x(); });
  std::vector<OnEdge> found;
  for (auto v = first; v != by_x.end() && point(*v).x() <= std::max(a.x(), b.x()) + weld_m; ++v) {
    if (std::ranges::count(face, *v) > 0) continue;
    const double along = (point(*v) - a).dot(direction);
    const double off = (point(*v) - a - along * direction).norm();
    if (off <= weld_m && along > weld_m && along < length - weld_m) found.push_back({along, *v});
  }
  std::ranges::sort(found, {}, &OnEdge::along);
  return found;
}

// Replaces the face by a fan from the corner opposite to its side.
void split_face(Soup& soup, const Side& side, const std::vector<OnEdge>& on_edge) {
  const auto f = static_cast<std::size_t>(side.face);
  const auto k = static_cast<std::size_t>(side.corner);
  const Triangle face = soup.faces[f];
  std::int32_t from = face[k];
  const std::int32_t to = face[(k + 1) % 3], apex = face[(k + 2) % 3];
  for (const OnEdge& next : on_edge) {
    soup.faces.push_back({from, next.vertex, apex});
    soup.origin.push_back(soup.origin[f]);
    soup.is_turned.push_back(soup.is_turned[f]);
    from = next.vertex;
  }
  soup.faces[f] = {from, to, apex};
}

}  // namespace

void split_t_junctions(Soup& soup, double weld_m, Changes& changes) {
  std::size_t split = 0;
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    std::vector<Side> border;
    for_each_edge(sorted_sides(soup.faces), [&](auto begin, auto end) {
      if (end - begin == 1) border.push_back(*begin);
    });
    const std::vector<std::int32_t> by_x = border_vertices_by_x(soup, border);
    std::vector<char> is_split(soup.faces.size(),
                               0);  // one side per pass: splitting moves the others
    const std::size_t before = split;
    for (const Side& side : border) {
      if (is_split[static_cast<std::size_t>(side.face)]) continue;
      const std::vector<OnEdge> on_edge = vertices_on(soup, side, by_x, weld_m);
      if (on_edge.empty()) continue;
      split_face(soup, side, on_edge);
      is_split[static_cast<std::size_t>(side.face)] = 1;
      ++split;
    }
    if (split == before) break;
  }
  if (split > 0)
    changes.push_back("split " + counted(split, "triangle", "triangles") +
                      " where a vertex lies on an edge (T-junctions)");
}

}  // namespace palpate::repair
