#include "libfem/mesh/repair/topology.hpp"

#include <algorithm>
#include <tuple>

namespace palpate::repair {

std::vector<Side> sorted_sides(const std::vector<Triangle>& faces) {
  std::vector<Side> sides;
  sides.reserve(3 * faces.size());
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t from = faces[f][k], to = faces[f][(k + 1) % 3];
      sides.push_back({std::min(from, to), std::max(from, to), static_cast<std::int32_t>(f),
                       static_cast<std::int8_t>(k), from < to});
    }
  std::ranges::sort(sides, [](const Side& a, const Side& b) {
    return std::tie(a.low, a.high, a.face, a.corner) < std::tie(b.low, b.high, b.face, b.corner);
  });
  return sides;
}

Components components(const std::vector<Triangle>& faces) {
  DisjointSets sets(faces.size());
  for_each_edge(sorted_sides(faces), [&](auto begin, auto end) {
    for (auto side = begin + 1; side < end; ++side)
      sets.join(static_cast<std::size_t>(begin->face), static_cast<std::size_t>(side->face));
  });
  Components result{std::vector<std::size_t>(faces.size()), 0};
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const std::size_t first = sets.find(f);
    result.of_face[f] = first == f ? result.number++ : result.of_face[first];
  }
  return result;
}

std::size_t count_pinched_vertices(const std::vector<Triangle>& faces, std::size_t vertices) {
  // A set per corner; corners at one vertex whose faces share an edge there join.
  DisjointSets corners(3 * faces.size());
  const auto corner_at = [&](const Side& side, std::int32_t vertex) {
    const auto f = static_cast<std::size_t>(side.face);
    const auto k = static_cast<std::size_t>(side.corner);
    return 3 * f + (faces[f][k] == vertex ? k : (k + 1) % 3);
  };
  for_each_edge(sorted_sides(faces), [&](auto begin, auto end) {
    for (auto side = begin + 1; side < end; ++side) {
      corners.join(corner_at(*begin, begin->low), corner_at(*side, begin->low));
      corners.join(corner_at(*begin, begin->high), corner_at(*side, begin->high));
    }
  });
  std::vector<int> fans(vertices, 0);
  for (std::size_t c = 0; c < 3 * faces.size(); ++c)
    if (corners.find(c) == c) ++fans[static_cast<std::size_t>(faces[c / 3][c % 3])];
  return static_cast<std::size_t>(std::ranges::count_if(fans, [](int n) { return n > 1; }));
}

std::vector<Triangle> to_faces(const Triangles& triangles) {
  std::vector<Triangle> faces(static_cast<std::size_t>(triangles.rows()));
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    faces[static_cast<std::size_t>(f)] = {triangles(f, 0), triangles(f, 1), triangles(f, 2)};
  return faces;
}

Surface to_surface(const std::vector<Vec3>& points, const std::vector<Triangle>& faces) {
  Surface surface;
  surface.vertices.resize(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t p = 0; p < points.size(); ++p)
    surface.vertices.row(static_cast<Eigen::Index>(p)) = points[p];
  surface.triangles.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t f = 0; f < faces.size(); ++f)
    surface.triangles.row(static_cast<Eigen::Index>(f)) << faces[f][0], faces[f][1], faces[f][2];
  return surface;
}

}  // namespace palpate::repair
