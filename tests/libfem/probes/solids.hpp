#pragma once

#include <map>

#include "libfit/core/geometry.hpp"

namespace palpate::fem {

/// An octahedron split `levels` times and blown up to a ball.
inline Surface ball_mesh(double radius_m, int levels) {
  std::vector<Vec3> x{Vec3::UnitX(),  Vec3::UnitY(), -Vec3::UnitX(),
                      -Vec3::UnitY(), Vec3::UnitZ(), -Vec3::UnitZ()};
  std::vector<std::array<int, 3>> t{{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4},
                                    {1, 0, 5}, {2, 1, 5}, {3, 2, 5}, {0, 3, 5}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<int, int>, int> middle;
    const auto between = [&](int a, int b) {
      const auto [found, is_new] =
          middle.try_emplace(std::minmax(a, b), static_cast<int>(x.size()));
      if (is_new) x.push_back((x[a] + x[b]).normalized());
      return found->second;
    };
    std::vector<std::array<int, 3>> next;
    for (const auto& [a, b, c] : t) {
      const int ab = between(a, b), bc = between(b, c), ca = between(c, a);
      next.insert(next.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    t = next;
  }
  Surface out;
  out.vertices.resize(static_cast<Eigen::Index>(x.size()), 3);
  for (std::size_t v = 0; v < x.size(); ++v)
    out.vertices.row(static_cast<Eigen::Index>(v)) = radius_m * x[v];
  out.triangles.resize(static_cast<Eigen::Index>(t.size()), 3);
  for (std::size_t f = 0; f < t.size(); ++f)
    out.triangles.row(static_cast<Eigen::Index>(f)) << t[f][0], t[f][1], t[f][2];
  return out;
}

/// A box about the origin, two triangles a side.
inline Surface box_mesh(const Vec3& half_m) {
  Surface out;
  out.vertices.resize(8, 3);
  for (int v = 0; v < 8; ++v)
    out.vertices.row(v) << (v & 1 ? 1 : -1) * half_m.x(), (v & 2 ? 1 : -1) * half_m.y(),
        (v & 4 ? 1 : -1) * half_m.z();
  out.triangles.resize(12, 3);
  out.triangles << 0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2,
      2, 4, 6, 1, 3, 5, 3, 7, 5;
  return out;
}

}  // namespace palpate::fem
