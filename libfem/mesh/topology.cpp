#include "libfem/mesh/topology.hpp"

#include <tuple>

namespace palpate {

std::vector<std::int32_t> renumber(std::span<std::int32_t> corners, std::size_t count,
                                   Numbering numbering) {
  std::vector<std::int32_t> number(count, -1), used;
  const auto take = [&](std::int32_t v) {
    if (number[v] >= 0) return;
    number[v] = static_cast<std::int32_t>(used.size());
    used.push_back(v);
  };
  if (numbering == Numbering::ascending) {
    used.assign(corners.begin(), corners.end());
    sort_unique(used);
    for (std::size_t i = 0; i < used.size(); ++i) number[used[i]] = static_cast<std::int32_t>(i);
  }
  for (std::int32_t& v : corners) {
    take(v);
    v = number[v];
  }
  return used;
}

std::vector<TriangleSide> sorted_sides(const Eigen::Ref<const Triangles>& triangles) {
  std::vector<TriangleSide> sides;
  sides.reserve(triangles.size());
  for (std::int32_t f = 0; f < triangles.rows(); ++f)
    for (std::int8_t k = 0; k < 3; ++k) {
      const std::int32_t from = triangles(f, k), to = triangles(f, (k + 1) % 3);
      sides.push_back({std::min(from, to), std::max(from, to), f, k, from < to});
    }
  std::ranges::sort(sides, [](const TriangleSide& a, const TriangleSide& b) {
    return std::tie(a.low, a.high, a.face, a.corner) < std::tie(b.low, b.high, b.face, b.corner);
  });
  return sides;
}

Components components(const Eigen::Ref<const Triangles>& triangles) {
  DisjointSets sets(triangles.rows());
  for_each_edge(sorted_sides(triangles), [&](auto begin, auto end) {
    for (auto side = begin + 1; side < end; ++side) sets.join(begin->face, side->face);
  });
  Components result{std::vector<std::size_t>(triangles.rows()), 0};
  for (std::size_t f = 0; f < result.of_face.size(); ++f) {
    const std::size_t first = sets.find(f);
    result.of_face[f] = first == f ? result.number++ : result.of_face[first];
  }
  return result;
}

// The corners are looked up: triangles may have been turned since their sides were listed.
void join_fans(const Eigen::Ref<const Triangles>& triangles, const TriangleSide& a,
               const TriangleSide& b, DisjointSets& corners) {
  const auto corner_at = [&](std::int32_t f, std::int32_t vertex) {
    return 3 * f + (triangles(f, 0) == vertex ? 0 : triangles(f, 1) == vertex ? 1 : 2);
  };
  for (const std::int32_t vertex : {a.low, a.high})
    corners.join(corner_at(a.face, vertex), corner_at(b.face, vertex));
}

DisjointSets corner_fans(const Eigen::Ref<const Triangles>& triangles) {
  DisjointSets corners(triangles.size());
  for_each_edge(sorted_sides(triangles), [&](auto begin, auto end) {
    for (auto side = begin + 1; side < end; ++side) join_fans(triangles, *begin, *side, corners);
  });
  return corners;
}

std::vector<std::int32_t> pinched_vertices(const Eigen::Ref<const Triangles>& triangles,
                                           std::size_t count) {
  DisjointSets fan_of = corner_fans(triangles);
  std::vector<int> fans(count, 0);
  for (std::size_t c = 0; c < 3 * std::size_t(triangles.rows()); ++c)
    fans[triangles(c / 3, c % 3)] += fan_of.find(c) == c;
  std::vector<std::int32_t> pinched;
  for (std::size_t v = 0; v < count; ++v)
    if (fans[v] > 1) pinched.push_back(v);
  return pinched;
}

}  // namespace palpate
