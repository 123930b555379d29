#include "libfit/refine/edge_paths.hpp"

#include <algorithm>
#include <functional>
#include <limits>
#include <queue>
#include <tuple>
#include <utility>

namespace palpate {

Neighbours::Neighbours(const Triangles& triangles, Eigen::Index vertices) {
  first_.assign(static_cast<std::size_t>(vertices) + 1, 0);
  vertex_.resize(static_cast<std::size_t>(triangles.size()) * 2);
  for (const std::int32_t v : triangles.reshaped()) first_[static_cast<std::size_t>(v) + 1] += 2;
  for (std::size_t v = 1; v < first_.size(); ++v) first_[v] += first_[v - 1];
  std::vector<std::int32_t> next(first_.begin(), first_.end() - 1);
  for (const auto& t : triangles.rowwise())
    for (int k = 0; k < 3; ++k)
      for (int other = 1; other < 3; ++other)
        vertex_[static_cast<std::size_t>(next[static_cast<std::size_t>(t[k])]++)] =
            t[(k + other) % 3];
  // An edge of two triangles is there twice.
  auto kept = vertex_.begin();
  for (std::size_t v = 0; v + 1 < first_.size(); ++v) {
    const auto begin = vertex_.begin() + first_[v], end = vertex_.begin() + first_[v + 1];
    std::sort(begin, end);
    first_[v] = static_cast<std::int32_t>(kept - vertex_.begin());
    kept = std::copy(begin, std::unique(begin, end), kept);
  }
  first_.back() = static_cast<std::int32_t>(kept - vertex_.begin());
  vertex_.erase(kept, vertex_.end());
}

NearestSource nearest_source(const Surface& surface, const std::vector<EdgePathSeeds>& sources) {
  using Item = std::tuple<double, std::int32_t, std::int32_t>;  // distance, source, vertex
  const Neighbours neighbours(surface.triangles, surface.vertices.rows());
  const auto vertices = static_cast<std::size_t>(surface.vertices.rows());
  NearestSource found{std::vector<std::int32_t>(vertices, -1),
                      std::vector<double>(vertices, std::numeric_limits<double>::infinity())};
  std::priority_queue<Item, std::vector<Item>, std::greater<>> front;
  const auto reach = [&](double distance_m, std::int32_t source, std::int32_t vertex) {
    const auto v = static_cast<std::size_t>(vertex);
    if (std::pair(distance_m, source) >= std::pair(found.distance_m[v], found.source[v])) return;
    found.distance_m[v] = distance_m;
    found.source[v] = source;
    front.emplace(distance_m, source, vertex);
  };
  for (std::size_t s = 0; s < sources.size(); ++s)
    for (const auto& seed : sources[s])
      reach(seed.distance_m, static_cast<std::int32_t>(s), seed.vertex);
  while (!front.empty()) {
    const auto [distance_m, source, vertex] = front.top();
    front.pop();
    const auto v = static_cast<std::size_t>(vertex);
    if (std::pair(distance_m, source) != std::pair(found.distance_m[v], found.source[v])) continue;
    for (const std::int32_t to : neighbours.of(vertex)) {
      const double length_m = (surface.vertices.row(to) - surface.vertices.row(vertex)).norm();
      reach(distance_m + length_m, source, to);
    }
  }
  return found;
}

}  // namespace palpate
