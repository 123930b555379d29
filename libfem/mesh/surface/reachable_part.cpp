#include "libfem/mesh/surface/reachable_part.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include "libfit/core/error.hpp"

namespace palpate {
namespace {

using TriangleList = std::vector<Eigen::Index>;

TriangleList reachable_triangles(const Surface& fine, const std::vector<char>& is_reachable) {
  if (fine.triangles.size() > 0 &&
      (fine.triangles.minCoeff() < 0 || fine.triangles.maxCoeff() >= fine.vertices.rows()))
    throw Error("surface", "a triangle names a vertex that does not exist", "Mend the surface.");
  TriangleList kept;
  for (Eigen::Index f = 0; f < fine.triangles.rows(); ++f) {
    const auto t = fine.triangles.row(f);
    const auto is_in = [&](int k) { return is_reachable[static_cast<std::size_t>(t[k])] != 0; };
    if (is_in(0) && is_in(1) && is_in(2)) kept.push_back(f);
  }
  return kept;
}

/// Splits the triangles around a vertex into fans: those that hang together by edges at it.
std::vector<TriangleList> fans_at(const Surface& fine, std::int32_t vertex,
                                  const TriangleList& around) {
  std::vector<TriangleList> fans;
  std::vector<std::vector<std::int32_t>> rims;  // the other vertices of each fan
  for (const Eigen::Index f : around) {
    TriangleList merged{f};
    std::vector<std::int32_t> rim;
    for (int k = 0; k < 3; ++k)
      if (fine.triangles(f, k) != vertex) rim.push_back(fine.triangles(f, k));
    for (std::size_t i = 0; i < fans.size();) {
      const bool touches = std::any_of(rims[i].begin(), rims[i].end(), [&](std::int32_t v) {
        return std::find(rim.begin(), rim.end(), v) != rim.end();
      });
      if (!touches) {
        ++i;
        continue;
      }
      merged.insert(merged.end(), fans[i].begin(), fans[i].end());
      rim.insert(rim.end(), rims[i].begin(), rims[i].end());
      fans.erase(fans.begin() + static_cast<std::ptrdiff_t>(i));
      rims.erase(rims.begin() + static_cast<std::ptrdiff_t>(i));
    }
    fans.push_back(std::move(merged));
    rims.push_back(std::move(rim));
  }
  return fans;
}

/// Drops all but the largest fan at vertices that have several; true when something was dropped.
bool drop_pinches(const Surface& fine, TriangleList& kept) {
  std::map<std::int32_t, TriangleList> around;
  for (const Eigen::Index f : kept)
    for (int k = 0; k < 3; ++k) around[fine.triangles(f, k)].push_back(f);
  TriangleList dropped;
  for (const auto& [vertex, triangles] : around) {
    const auto fans = fans_at(fine, vertex, triangles);
    if (fans.size() < 2) continue;
    const auto largest = std::max_element(
        fans.begin(), fans.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); });
    for (auto fan = fans.begin(); fan != fans.end(); ++fan)
      if (fan != largest) dropped.insert(dropped.end(), fan->begin(), fan->end());
  }
  std::sort(dropped.begin(), dropped.end());
  std::erase_if(
      kept, [&](Eigen::Index f) { return std::binary_search(dropped.begin(), dropped.end(), f); });
  return !dropped.empty();
}

}  // namespace

ReachablePart reachable_part(const Surface& fine, const std::vector<char>& is_reachable) {
  TriangleList kept = reachable_triangles(fine, is_reachable);
  while (drop_pinches(fine, kept)) {
  }
  if (kept.empty())
    throw Error("reachable part", "no triangle of the surface can be touched",
                "Widen the region, or hold less of the surface.");

  std::vector<std::int32_t> used(static_cast<std::size_t>(fine.vertices.rows()), 0);
  for (const Eigen::Index f : kept)
    for (int k = 0; k < 3; ++k) used[static_cast<std::size_t>(fine.triangles(f, k))] = 1;
  const auto count = std::accumulate(used.begin(), used.end(), std::int32_t{0});
  std::exclusive_scan(used.begin(), used.end(), used.begin(), std::int32_t{0});

  const Points normals = vertex_normals(fine);
  ReachablePart part{{Points(count, 3), Triangles(static_cast<Eigen::Index>(kept.size()), 3)},
                     Points(count, 3),
                     std::vector<std::int32_t>(static_cast<std::size_t>(count))};
  for (std::size_t i = 0; i < kept.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t from = fine.triangles(kept[i], k);
      const std::int32_t to = used[static_cast<std::size_t>(from)];
      part.surface.triangles(static_cast<Eigen::Index>(i), k) = to;
      part.surface.vertices.row(to) = fine.vertices.row(from);
      part.normals.row(to) = normals.row(from);
      part.vertex[static_cast<std::size_t>(to)] = from;
    }
  return part;
}

}  // namespace palpate
