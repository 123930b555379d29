#include "libfit/refine/edge_paths.hpp"

#include <algorithm>
#include <functional>
#include <limits>
#include <queue>
#include <tuple>
#include <utility>

namespace palpate {

Neighbours::Neighbours(const Triangles& triangles, Eigen::Index vertices)
    : NumberLists(triangles, vertices, 2,
                  [&](int t, int k, int i) { return triangles(t, (k + 1 + i) % 3); }) {
  auto kept = number_.begin();  // an edge of two triangles is there twice
  for (std::size_t v = 0; v + 1 < first_.size(); ++v) {
    const auto begin = number_.begin() + first_[v], end = number_.begin() + first_[v + 1];
    std::sort(begin, end);
    first_[v] = kept - number_.begin();
    kept = std::copy(begin, std::unique(begin, end), kept);
  }
  first_.back() = kept - number_.begin();
  number_.erase(kept, number_.end());
}

NearestSource nearest_source(const Surface& surface, const std::vector<EdgePathSeeds>& sources) {
  using Item = std::tuple<double, std::int32_t, std::int32_t>;  // distance, source, vertex
  const Neighbours neighbours(surface.triangles, surface.vertices.rows());
  const std::size_t vertices = surface.vertices.rows();
  NearestSource found{std::vector<std::int32_t>(vertices, -1),
                      std::vector<double>(vertices, std::numeric_limits<double>::infinity())};
  std::priority_queue<Item, std::vector<Item>, std::greater<>> front;
  const auto reach = [&](double distance_m, std::int32_t source, std::int32_t vertex) {
    if (std::pair(distance_m, source) >= std::pair(found.distance_m[vertex], found.source[vertex]))
      return;
    found.distance_m[vertex] = distance_m;
    found.source[vertex] = source;
    front.emplace(distance_m, source, vertex);
  };
  for (std::size_t s = 0; s < sources.size(); ++s)
    for (const auto& seed : sources[s]) reach(seed.distance_m, s, seed.vertex);
  while (!front.empty()) {
    const auto [distance_m, source, vertex] = front.top();
    front.pop();
    if (std::pair(distance_m, source) != std::pair(found.distance_m[vertex], found.source[vertex]))
      continue;
    for (const std::int32_t to : neighbours.of(vertex)) {
      const double length_m = (surface.vertices.row(to) - surface.vertices.row(vertex)).norm();
      reach(distance_m + length_m, source, to);
    }
  }
  return found;
}

}  // namespace palpate
