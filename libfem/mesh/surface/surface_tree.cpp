#include "libfem/mesh/surface/surface_tree.hpp"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <vector>

#include "libfit/core/error.hpp"

namespace palpate {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Triangle = Kernel::Triangle_3;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, std::vector<Triangle>::const_iterator>;
using AabbTree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

Kernel::Point_3 to_point(const Vec3& p) { return {p.x(), p.y(), p.z()}; }
Vec3 to_vec3(const Kernel::Point_3& p) { return {p.x(), p.y(), p.z()}; }

/// Barycentric coordinates of a point of the triangle's plane, clamped to the triangle.
Vec3 barycentric(const Triangle& t, const Vec3& point) {
  const Vec3 a = to_vec3(t[0]), b = to_vec3(t[1]), c = to_vec3(t[2]);
  const Vec3 normal = (b - a).cross(c - a);
  Vec3 weight;
  weight[0] = normal.dot((c - b).cross(point - b));
  weight[1] = normal.dot((a - c).cross(point - c));
  weight[2] = normal.dot((b - a).cross(point - a));
  weight = weight.cwiseMax(0.0);
  return weight / weight.sum();
}

}  // namespace

struct SurfaceTree::Tree {
  std::vector<Triangle> triangles;
  std::vector<std::int32_t> index;  ///< of each kept triangle in the surface
  AabbTree aabb;
};

SurfaceTree::SurfaceTree(const Surface& surface) : tree_(std::make_unique<Tree>()) {
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f) {
    Vec3 corner[3];
    for (int k = 0; k < 3; ++k) corner[k] = surface.vertices.row(surface.triangles(f, k));
    if (!((corner[1] - corner[0]).cross(corner[2] - corner[0]).norm() > 0)) continue;
    tree_->triangles.emplace_back(to_point(corner[0]), to_point(corner[1]), to_point(corner[2]));
    tree_->index.push_back(static_cast<std::int32_t>(f));
  }
  if (tree_->triangles.empty())
    throw Error("surface", "it has no triangle with area", "Give a surface with triangles.");
  tree_->aabb.insert(tree_->triangles.cbegin(), tree_->triangles.cend());
  tree_->aabb.build();
  tree_->aabb.accelerate_distance_queries();  // now, so that queries are const in earnest
}

SurfaceTree::~SurfaceTree() = default;
SurfaceTree::SurfaceTree(SurfaceTree&&) noexcept = default;
SurfaceTree& SurfaceTree::operator=(SurfaceTree&&) noexcept = default;

SurfaceHit SurfaceTree::closest(const Vec3& query) const {
  const auto [point, primitive] = tree_->aabb.closest_point_and_primitive(to_point(query));
  const auto at = primitive - tree_->triangles.cbegin();
  SurfaceHit hit;
  hit.point = to_vec3(point);
  hit.triangle = tree_->index[static_cast<std::size_t>(at)];
  hit.barycentric = barycentric(*primitive, hit.point);
  hit.distance_m = (hit.point - query).norm();
  return hit;
}

std::optional<double> SurfaceTree::ray_distance_m(const Vec3& origin, const Vec3& direction,
                                                  double skip_m) const {
  const Vec3 start = origin + skip_m * direction;
  const Kernel::Ray_3 ray(to_point(start), to_point(start + direction));
  const auto met = tree_->aabb.first_intersection(ray);
  if (!met) return std::nullopt;
  if (const auto* point = boost::get<Kernel::Point_3>(&met->first))
    return skip_m + (to_vec3(*point) - start).norm();
  return skip_m;  // the ray runs within a triangle
}

namespace {

double one_sided_deviation_m(const Surface& from, const SurfaceTree& to) {
  double largest = 0;
  const auto sample = [&](const Vec3& p) { largest = std::max(largest, to.closest(p).distance_m); };
  for (Eigen::Index f = 0; f < from.triangles.rows(); ++f) {
    Vec3 corner[3];
    for (int k = 0; k < 3; ++k) corner[k] = from.vertices.row(from.triangles(f, k));
    for (int k = 0; k < 3; ++k) {
      const int next = (k + 1) % 3;
      if (from.triangles(f, k) > from.triangles(f, next)) continue;  // once per edge, when closed
      sample(corner[k]);
      sample((corner[k] + corner[next]) / 2);
    }
    sample((corner[0] + corner[1] + corner[2]) / 3);
  }
  return largest;
}

}  // namespace

double deviation_m(const Surface& a, const SurfaceTree& tree_of_a, const Surface& b) {
  return std::max(one_sided_deviation_m(b, tree_of_a), one_sided_deviation_m(a, SurfaceTree(b)));
}

}  // namespace palpate
