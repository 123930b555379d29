#include "libfit/refine/edge_paths.hpp"

#include <algorithm>
#include <functional>
#include <limits>
#include <queue>
#include <tuple>

namespace palpate {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <class Item>
using SmallestFirst = std::priority_queue<Item, std::vector<Item>, std::greater<>>;

}  // namespace

EdgePaths::EdgePaths(const Surface& surface)
    : surface_(surface),
      first_(static_cast<std::size_t>(surface.vertices.rows()) + 1, 0),
      neighbour_(static_cast<std::size_t>(surface.triangles.size()) * 2),
      distance_(static_cast<std::size_t>(surface.vertices.rows()), kInfinity) {
  const Triangles& triangles = surface.triangles;  // an edge of two triangles is listed twice
  for (Eigen::Index i = 0; i < triangles.size(); ++i)
    first_[static_cast<std::size_t>(triangles.data()[i]) + 1] += 2;
  for (std::size_t v = 1; v < first_.size(); ++v) first_[v] += first_[v - 1];
  std::vector<std::int32_t> next(first_.begin(), first_.end() - 1);
  for (Eigen::Index t = 0; t < triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k)
      for (int other = 1; other < 3; ++other)
        neighbour_[static_cast<std::size_t>(next[static_cast<std::size_t>(triangles(t, k))]++)] =
            triangles(t, (k + other) % 3);
}

template <class Visit>
void EdgePaths::for_each_neighbour(std::int32_t vertex, const Visit& visit) const {
  const auto v = static_cast<std::size_t>(vertex);
  for (auto i = static_cast<std::size_t>(first_[v]); i < static_cast<std::size_t>(first_[v + 1]); ++i)
    visit(neighbour_[i],
          (surface_.vertices.row(neighbour_[i]) - surface_.vertices.row(vertex)).norm());
}

std::vector<std::int32_t> EdgePaths::nearest_source(
    const std::vector<EdgePathSeeds>& sources) const {
  using Item = std::tuple<double, std::int32_t, std::int32_t>;  // distance, source, vertex
  SmallestFirst<Item> front;
  for (std::size_t s = 0; s < sources.size(); ++s)
    for (const auto& seed : sources[s])
      front.emplace(seed.distance_m, static_cast<std::int32_t>(s), seed.vertex);
  std::vector<std::int32_t> owner(distance_.size(), -1);
  while (!front.empty()) {
    const auto [distance_m, source, vertex] = front.top();
    front.pop();
    if (owner[static_cast<std::size_t>(vertex)] >= 0) continue;
    owner[static_cast<std::size_t>(vertex)] = source;
    for_each_neighbour(vertex, [&, d = distance_m, s = source](std::int32_t to, double length_m) {
      if (owner[static_cast<std::size_t>(to)] < 0) front.emplace(d + length_m, s, to);
    });
  }
  return owner;
}

std::vector<std::int32_t> EdgePaths::within(const EdgePathSeeds& source, double most_m) {
  using Item = std::pair<double, std::int32_t>;
  SmallestFirst<Item> front;
  std::vector<std::int32_t> found;
  const auto reach = [&](std::int32_t vertex, double distance_m) {
    double& known_m = distance_[static_cast<std::size_t>(vertex)];
    if (!(distance_m < known_m)) return;
    if (known_m == kInfinity) found.push_back(vertex);
    known_m = distance_m;
    front.emplace(distance_m, vertex);
  };
  for (const auto& seed : source) reach(seed.vertex, seed.distance_m);
  while (!front.empty()) {
    const auto [distance_m, vertex] = front.top();
    front.pop();
    if (distance_m > distance_[static_cast<std::size_t>(vertex)]) continue;
    for_each_neighbour(vertex, [&, d = distance_m](std::int32_t to, double length_m) {
      if (d + length_m <= most_m) reach(to, d + length_m);
    });
  }
  for (const std::int32_t vertex : found) distance_[static_cast<std::size_t>(vertex)] = kInfinity;
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace palpate
