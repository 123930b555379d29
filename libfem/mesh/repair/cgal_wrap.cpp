#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/alpha_wrap_3.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "libfem/mesh/repair/cgal_mesh.hpp"
#include "libfem/mesh/repair/cgal_steps.hpp"

namespace palpate::repair {
namespace {

std::vector<Kernel::Triangle_3> triangles_of(const Surface& surface) {
  std::vector<Kernel::Triangle_3> triangles;
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f) {
    const auto corner = [&](int k) {
      return to_cgal(Vec3(surface.vertices.row(surface.triangles(f, k))));
    };
    triangles.emplace_back(corner(0), corner(1), corner(2));
  }
  return triangles;
}

class DistanceTo {
 public:
  explicit DistanceTo(const Surface& surface)
      : triangles_(triangles_of(surface)), tree_(triangles_.begin(), triangles_.end()) {}

  // Largest distance of points on `other`, at most `spacing_m` apart.
  double farthest_m(const Surface& other, double spacing_m) const {
    double most = 0;
    for (Eigen::Index f = 0; f < other.triangles.rows(); ++f) {
      const Vec3 a = other.vertices.row(other.triangles(f, 0));
      const Vec3 u = Vec3(other.vertices.row(other.triangles(f, 1))) - a;
      const Vec3 v = Vec3(other.vertices.row(other.triangles(f, 2))) - a;
      const double longest = std::max({u.norm(), v.norm(), (u - v).norm()});
      const int steps = std::clamp(static_cast<int>(std::ceil(longest / spacing_m)), 1, 200);
      for (int i = 0; i <= steps; ++i)
        for (int j = 0; i + j <= steps; ++j)
          most = std::max(most, tree_.squared_distance(to_cgal(Vec3(a + (i * u + j * v) / steps))));
    }
    return std::sqrt(most);
  }

 private:
  using Primitive =
      CGAL::AABB_triangle_primitive<Kernel, std::vector<Kernel::Triangle_3>::const_iterator>;
  std::vector<Kernel::Triangle_3> triangles_;
  CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>> tree_;
};

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
  result.farthest_m = std::max(DistanceTo(result.surface).farthest_m(surface, spacing_m),
                               DistanceTo(surface).farthest_m(result.surface, spacing_m));
  return result;
}

}  // namespace palpate::repair
