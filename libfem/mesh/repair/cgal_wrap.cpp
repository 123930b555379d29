#include <CGAL/alpha_wrap_3.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "libfem/mesh/repair/cgal_mesh.hpp"
#include "libfem/mesh/repair/cgal_steps.hpp"
#include "libfit/core/closest_point.hpp"

namespace palpate::repair {
namespace {

// Largest distance to `to` of points on `from`, at most `spacing_m` apart.
double farthest_m(const Surface& from, const Surface& to, double spacing_m) {
  const BoxTree boxes = triangle_boxes(to);
  double farthest = 0;
  for (Eigen::Index f = 0; f < from.triangles.rows(); ++f) {
    const Vec3 a = from.vertices.row(from.triangles(f, 0));
    const Vec3 u = Vec3(from.vertices.row(from.triangles(f, 1))) - a;
    const Vec3 v = Vec3(from.vertices.row(from.triangles(f, 2))) - a;
    const double longest = std::max({u.norm(), v.norm(), (u - v).norm()});
    const int steps = std::clamp(static_cast<int>(std::ceil(longest / spacing_m)), 1, 200);
    for (int i = 0; i <= steps; ++i)
      for (int j = 0; i + j <= steps; ++j)
        if (const auto hit = closest_point(to, boxes, a + (i * u + j * v) / steps))
          farthest = std::max(farthest, hit->distance_m);
  }
  return farthest;
}

}  // namespace

Wrapped wrap_surface(const Surface& surface, double alpha_m, double offset_m) {
  std::vector<CgalPoint> points;
  for (Eigen::Index v = 0; v < surface.vertices.rows(); ++v)
    points.push_back(to_cgal(Vec3(surface.vertices.row(v))));
  std::vector<std::array<std::size_t, 3>> faces;
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f)
    faces.push_back({static_cast<std::size_t>(surface.triangles(f, 0)),
                     static_cast<std::size_t>(surface.triangles(f, 1)),
                     static_cast<std::size_t>(surface.triangles(f, 2))});
  CgalMesh mesh;
  CGAL::alpha_wrap_3(points, faces, alpha_m, offset_m, mesh);
  Wrapped result{from_cgal(mesh), 0};
  const double spacing_m = alpha_m / 2;
  result.farthest_m = std::max(farthest_m(surface, result.surface, spacing_m),
                               farthest_m(result.surface, surface, spacing_m));
  return result;
}

}  // namespace palpate::repair
