#include "tests/libfem/mesh/repair/shapes.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <tuple>

namespace palpate::mesh_repair_test {

Surface box(double edge_m, const Vec3& low, int pieces) {
  std::map<std::tuple<int, int, int>, int> index;
  std::vector<Vec3> points;
  std::vector<Eigen::Vector3i> faces;
  const auto vertex = [&](const Eigen::Vector3i& at) {
    const auto [found, is_new] =
        index.try_emplace({at.x(), at.y(), at.z()}, static_cast<int>(points.size()));
    if (is_new) points.push_back(low + edge_m / pieces * at.cast<double>());
    return found->second;
  };
  for (int axis = 0; axis < 3; ++axis)
    for (const int side : {0, pieces})
      for (int i = 0; i < pieces; ++i)
        for (int j = 0; j < pieces; ++j) {
          const auto at = [&](int u, int v) {
            Eigen::Vector3i p;
            p[axis] = side;
            p[(axis + 1) % 3] = i + u;
            p[(axis + 2) % 3] = j + v;
            return vertex(p);
          };
          const int a = at(0, 0), b = at(1, 0), c = at(1, 1), d = at(0, 1);
          if (side > 0) {
            faces.insert(faces.end(), {{a, b, c}, {a, c, d}});
          } else {
            faces.insert(faces.end(), {{a, c, b}, {a, d, c}});
          }
        }
  Surface surface{Points(points.size(), 3), Triangles(faces.size(), 3)};
  for (std::size_t p = 0; p < points.size(); ++p)
    surface.vertices.row(static_cast<Eigen::Index>(p)) = points[p];
  for (std::size_t f = 0; f < faces.size(); ++f)
    surface.triangles.row(static_cast<Eigen::Index>(f)) = faces[f];
  return surface;
}

Surface ball(double radius_m, const Vec3& middle, int n) {
  Surface surface = box(2, Vec3::Constant(-1), std::max(n / 2, 2));
  for (Eigen::Index v = 0; v < surface.vertices.rows(); ++v)
    surface.vertices.row(v) = middle.transpose() + radius_m * surface.vertices.row(v).normalized();
  return surface;
}

Surface without(const Surface& surface, const std::vector<Eigen::Index>& triangles) {
  Surface rest{
      surface.vertices,
      Triangles(surface.triangles.rows() - static_cast<Eigen::Index>(triangles.size()), 3)};
  Eigen::Index kept = 0;
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f)
    if (std::find(triangles.begin(), triangles.end(), f) == triangles.end())
      rest.triangles.row(kept++) = surface.triangles.row(f);
  return rest;
}

Surface with_triangle(Surface surface, const Vec3& a, const Vec3& b, const Vec3& c) {
  Surface triangle{Points(3, 3), Triangles(1, 3)};
  triangle.vertices << a.transpose(), b.transpose(), c.transpose();
  triangle.triangles << 0, 1, 2;
  return together(surface, triangle);
}

Surface torn(const Surface& surface, double noise_m, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> noise(-noise_m, noise_m);
  Surface result{Points(3 * surface.triangles.rows(), 3), Triangles(surface.triangles.rows(), 3)};
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const Eigen::Index v = 3 * f + k;
      result.vertices.row(v) = surface.vertices.row(surface.triangles(f, k));
      for (int i = 0; i < 3; ++i) result.vertices(v, i) += noise(random);
      result.triangles(f, k) = static_cast<int>(v);
    }
  return result;
}

}  // namespace palpate::mesh_repair_test
