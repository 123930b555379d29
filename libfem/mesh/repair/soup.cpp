#include "libfem/mesh/repair/repair_steps.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <unordered_map>

namespace palpate::repair {
namespace {

Vec3 corner(const Soup& soup, std::size_t face, std::size_t k) {
  return soup.points[soup.faces[face][k % 3]];
}

double face_area(const Soup& soup, std::size_t f) {
  const Vec3 a = corner(soup, f, 0);
  return 0.5 * (corner(soup, f, 1) - a).cross(corner(soup, f, 2) - a).norm();
}

// Lowest height of a triangle; 0 when all corners agree.
double lowest_height_m(const Soup& soup, std::size_t f) {
  double longest = 0;
  for (std::size_t k = 0; k < 3; ++k)
    longest = std::max(longest, (corner(soup, f, k + 1) - corner(soup, f, k)).norm());
  return longest > 0 ? 2 * face_area(soup, f) / longest : 0;
}

using Cell = std::array<std::int64_t, 3>;
struct HashCell {
  std::size_t operator()(const Cell& cell) const {
    return hash_of({reinterpret_cast<const char*>(cell.data()), sizeof cell});
  }
};

struct OnEdge {
  double along;
  std::int32_t vertex;
};

std::vector<std::int32_t> border_vertices_by_x(const Soup& soup,
                                               const std::vector<TriangleSide>& border) {
  std::vector<std::int32_t> vertices;
  for (const TriangleSide& side : border) vertices.insert(vertices.end(), {side.low, side.high});
  const auto x_of = [&](std::int32_t v) { return soup.points[v].x(); };
  std::ranges::sort(vertices, [&](std::int32_t a, std::int32_t b) {
    return std::pair(x_of(a), a) < std::pair(x_of(b), b);
  });
  vertices.erase(std::ranges::unique(vertices).begin(), vertices.end());
  return vertices;
}

// Border vertices on the inside of a side, in the side's direction.
std::vector<OnEdge> vertices_on(const Soup& soup, const TriangleSide& side,
                                const std::vector<std::int32_t>& by_x, double weld_m) {
  const auto point = [&](std::int32_t v) -> const Vec3& { return soup.points[v]; };
  const Triangle& face = soup.faces[side.face];
  const int k = side.corner;
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
void split_face(Soup& soup, const TriangleSide& side, const std::vector<OnEdge>& on_edge) {
  const std::int32_t f = side.face;
  const int k = side.corner;
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

Soup to_soup(const Surface& surface) {
  Soup soup;
  for (const auto& p : surface.vertices.rowwise()) soup.points.emplace_back(p.transpose());
  for (const auto& t : surface.triangles.rowwise()) soup.faces.push_back({t[0], t[1], t[2]});
  soup.origin.resize(soup.faces.size());
  std::iota(soup.origin.begin(), soup.origin.end(), 0);
  soup.is_turned.assign(soup.faces.size(), 0);
  return soup;
}

Surface to_surface(const Soup& soup) { return {rows_of(soup.points), rows_of(soup.faces)}; }

std::size_t keep_faces(Soup& soup, const std::vector<char>& keep) {
  std::size_t kept = 0;
  for (std::size_t f = 0; f < soup.faces.size(); ++f) {
    if (!keep[f]) continue;
    soup.faces[kept] = soup.faces[f];
    soup.origin[kept] = soup.origin[f];
    soup.is_turned[kept++] = soup.is_turned[f];
  }
  soup.faces.resize(kept);
  soup.origin.resize(kept);
  soup.is_turned.resize(kept);
  return keep.size() - kept;
}

void weld_vertices(Soup& soup, double weld_m, Changes& changes) {
  Vec3 low = soup.points.front();
  for (const Vec3& p : soup.points) low = low.cwiseMin(p);
  std::unordered_map<Cell, std::vector<std::size_t>, HashCell> grid;
  DisjointSets sets(soup.points.size());
  std::size_t welded = 0;
  for (std::size_t v = 0; v < soup.points.size(); ++v) {
    const Vec3 at = (soup.points[v] - low) / weld_m;
    const Cell cell{static_cast<std::int64_t>(at.x()), static_cast<std::int64_t>(at.y()),
                    static_cast<std::int64_t>(at.z())};
    bool is_new = true;
    for (int i = 0; i < 27 && is_new; ++i) {
      const auto found =
          grid.find({cell[0] + i % 3 - 1, cell[1] + i / 3 % 3 - 1, cell[2] + i / 9 - 1});
      if (found == grid.end()) continue;
      for (const std::size_t other : found->second)
        if (is_new && (soup.points[other] - soup.points[v]).norm() <= weld_m) {
          sets.join(other, v);
          is_new = false;
        }
    }
    // Only first comers are met by later ones: a row of close vertices does not collapse into one.
    if (is_new) grid[cell].push_back(v);
    welded += !is_new;
  }
  if (welded == 0) return;
  for (Triangle& face : soup.faces)
    for (std::int32_t& v : face) v = static_cast<std::int32_t>(sets.find(v));
  changes.push_back("welded " + counted(welded, "duplicate vertex", "duplicate vertices"));
}

void drop_flat_faces(Soup& soup, double weld_m, Changes& changes) {
  std::vector<char> keep(soup.faces.size());
  for (std::size_t f = 0; f < keep.size(); ++f) {
    const Triangle& t = soup.faces[f];
    keep[f] = t[0] != t[1] && t[1] != t[2] && t[2] != t[0] && lowest_height_m(soup, f) > weld_m;
  }
  if (const std::size_t dropped = keep_faces(soup, keep))
    changes.push_back("dropped " + counted(dropped, "triangle", "triangles") + " without area");
}

void drop_duplicate_faces(Soup& soup, Changes& changes) {
  std::vector<char> keep = repeats(soup.faces);
  for (char& flag : keep) flag ^= 1;
  if (const std::size_t dropped = keep_faces(soup, keep))
    changes.push_back("dropped " + counted(dropped, "duplicate triangle", "duplicate triangles"));
}

void drop_stray_components(Soup& soup, double smallest_share, Changes& changes) {
  const Components parts = components(rows_of(soup.faces));
  std::vector<double> area(parts.number, 0);
  for (std::size_t f = 0; f < soup.faces.size(); ++f) area[parts.of_face[f]] += face_area(soup, f);
  const double least = smallest_share * std::ranges::max(area);
  std::vector<char> keep(soup.faces.size());
  for (std::size_t f = 0; f < keep.size(); ++f) keep[f] = area[parts.of_face[f]] >= least;
  std::size_t dropped = 0;
  double largest = 0;
  for (const double each : area)
    if (each < least) {
      ++dropped;
      largest = std::max(largest, each);
    }
  if (dropped == 0) return;
  const std::size_t dropped_faces = keep_faces(soup, keep);
  changes.push_back("dropped " + counted(dropped, "stray piece", "stray pieces") + " of " +
                    counted(dropped_faces, "triangle", "triangles") + " in all (largest: " +
                    number(largest / std::ranges::max(area), 2) + " of the body's area)");
}

void drop_unused_vertices(Soup& soup) {
  const std::vector<std::int32_t> used = renumber(
      {soup.faces.front().data(), 3 * soup.faces.size()}, soup.points.size(), Numbering::ascending);
  for (std::size_t v = 0; v < used.size(); ++v) soup.points[v] = soup.points[used[v]];
  soup.points.resize(used.size());
}

std::string name_faces(const Soup& soup, const std::vector<std::int32_t>& faces) {
  std::vector<std::int32_t> numbers;
  for (const std::int32_t f : faces) numbers.push_back(soup.origin[f] + 1);
  sort_unique(numbers);
  std::string text = numbers.size() == 1 ? "triangle " : "triangles ";
  for (std::size_t i = 0; i < std::min<std::size_t>(numbers.size(), 6); ++i) {
    if (i > 0) text += ", ";
    text += std::to_string(numbers[i]);
  }
  if (numbers.size() > 6) text += ", ... (" + std::to_string(numbers.size()) + " in all)";
  return text;
}

void split_t_junctions(Soup& soup, double weld_m, Changes& changes) {
  std::size_t split = 0;
  for (int pass = 0; pass < 8;
       ++pass) {  // a triangle can be hit on each side, and its halves again
    std::vector<TriangleSide> border;
    for_each_edge(sorted_sides(rows_of(soup.faces)), [&](auto begin, auto end) {
      if (end - begin == 1) border.push_back(*begin);
    });
    const std::vector<std::int32_t> by_x = border_vertices_by_x(soup, border);
    std::vector<char> is_split(soup.faces.size(),
                               0);  // one side per pass: splitting moves the others
    const std::size_t before = split;
    for (const TriangleSide& side : border) {
      if (is_split[side.face]) continue;
      const std::vector<OnEdge> on_edge = vertices_on(soup, side, by_x, weld_m);
      if (on_edge.empty()) continue;
      split_face(soup, side, on_edge);
      is_split[side.face] = 1;
      ++split;
    }
    if (split == before) break;
  }
  if (split > 0)
    changes.push_back("split " + counted(split, "triangle", "triangles") +
                      " where a vertex lies on an edge (T-junctions)");
}

}  // namespace palpate::repair
