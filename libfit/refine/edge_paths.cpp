#include "libfit/refine/edge_paths.hpp"

#include <functional>
#include <limits>
#include <queue>
#include <tuple>

namespace palpate {
namespace {

// Neighbours of each vertex in compressed rows; an edge of two triangles is listed twice.
struct Neighbours {
  std::vector<std::int32_t> first, vertex;
};

Neighbours neighbours_of(const Surface& surface) {
  const Triangles& triangles = surface.triangles;
  Neighbours out;
  out.first.assign(static_cast<std::size_t>(surface.vertices.rows()) + 1, 0);
  out.vertex.resize(static_cast<std::size_t>(triangles.size()) * 2);
  for (Eigen::Index i = 0; i < triangles.size(); ++i)
    out.first[static_cast<std::size_t>(triangles.data()[i]) + 1] += 2;
  for (std::size_t v = 1; v < out.first.size(); ++v) out.first[v] += out.first[v - 1];
  std::vector<std::int32_t> next(out.first.begin(), out.first.end() - 1);
  for (Eigen::Index t = 0; t < triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k)
      for (int other = 1; other < 3; ++other) {
        auto& at = next[static_cast<std::size_t>(triangles(t, k))];
        out.vertex[static_cast<std::size_t>(at++)] = triangles(t, (k + other) % 3);
      }
  return out;
}

}  // namespace

NearestSource nearest_source(const Surface& surface, const std::vector<EdgePathSeeds>& sources) {
  using Item = std::tuple<double, std::int32_t, std::int32_t>;  // distance, source, vertex
  const Neighbours neighbours = neighbours_of(surface);
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
    const auto end = static_cast<std::size_t>(neighbours.first[v + 1]);
    for (auto i = static_cast<std::size_t>(neighbours.first[v]); i < end; ++i) {
      const std::int32_t to = neighbours.vertex[i];
      const double length_m = (surface.vertices.row(to) - surface.vertices.row(vertex)).norm();
      reach(distance_m + length_m, source, to);
    }
  }
  return found;
}

}  // namespace palpate
