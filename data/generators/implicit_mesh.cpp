#include "data/generators/implicit_mesh.hpp"

#include <CGAL/Complex_2_in_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Implicit_surface_3.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Random.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_default_triangulation_3.h>
#include <CGAL/make_surface_mesh.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <map>
#include <utility>
#include <vector>

namespace palpate::bodies {
namespace {

using Triangulation = CGAL::Surface_mesh_default_triangulation_3;
using Complex = CGAL::Complex_2_in_triangulation_3<Triangulation>;
using Traits = Triangulation::Geom_traits;

constexpr double kDifference_mm = 1e-3;  // step of central differences; fields are smooth over it

Vec3 gradient(const Field& field, const Vec3& x) {
  Vec3 out;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 step = kDifference_mm * Vec3::Unit(axis);
    out[axis] = (field(x + step) - field(x - step)) / (2 * kDifference_mm);
  }
  return out;
}

// Newton along the gradient; fields are near distances, so a few steps reach rounding.
Vec3 on_surface(const Field& field, Vec3 x) {
  for (int step = 0; step < 8; ++step) {
    const Vec3 slope = gradient(field, x);
    x -= field(x) / slope.squaredNorm() * slope;
  }
  return x;
}

Surface delaunay_surface(const Field& field, const ImplicitMeshOptions& options) {
  const auto value = [&field](const Traits::Point_3& p) { return field({p.x(), p.y(), p.z()}); };
  using Function = decltype(value);
  const CGAL::Implicit_surface_3<Traits, Function> surface(
      value, Traits::Sphere_3(CGAL::ORIGIN, options.reach_mm * options.reach_mm), 1e-7);
  CGAL::get_default_random() = CGAL::Random(1);  // else seeded by the clock
  Triangulation triangulation;
  Complex complex(triangulation);
  CGAL::make_surface_mesh(complex, surface,
                          CGAL::Surface_mesh_default_criteria_3<Triangulation>(
                              30, options.radius_mm, options.distance_mm),
                          CGAL::Manifold_tag());

  std::map<std::array<double, 3>, std::int32_t> vertex_at;
  std::vector<std::array<std::array<double, 3>, 3>> facets;
  for (auto facet = complex.facets_begin(); facet != complex.facets_end(); ++facet) {
    std::array<std::array<double, 3>, 3> corner;
    for (int k = 0; k < 3; ++k) {
      const auto& p = facet->first->vertex((facet->second + 1 + k) % 4)->point();
      corner[static_cast<std::size_t>(k)] = {p.x(), p.y(), p.z()};
      vertex_at.try_emplace({p.x(), p.y(), p.z()}, 0);
    }
    facets.push_back(corner);
  }

  Surface out;
  out.vertices.resize(static_cast<Eigen::Index>(vertex_at.size()), 3);
  std::int32_t next = 0;
  for (auto& [position, index] : vertex_at) {
    out.vertices.row(next) << position[0], position[1], position[2];
    index = next++;
  }
  std::vector<std::array<std::int32_t, 3>> rows;
  for (const auto& facet : facets) {
    std::array<std::int32_t, 3> row;
    for (std::size_t k = 0; k < 3; ++k) row[k] = vertex_at.at(facet[k]);
    std::rotate(row.begin(), std::min_element(row.begin(), row.end()), row.end());
    const Vec3 a = out.vertices.row(row[0]), b = out.vertices.row(row[1]),
               c = out.vertices.row(row[2]);
    if ((b - a).cross(c - a).dot(gradient(field, (a + b + c) / 3)) < 0) std::swap(row[1], row[2]);
    rows.push_back(row);
  }
  std::sort(rows.begin(), rows.end());
  out.triangles.resize(static_cast<Eigen::Index>(rows.size()), 3);
  for (std::size_t f = 0; f < rows.size(); ++f)
    out.triangles.row(static_cast<Eigen::Index>(f)) << rows[f][0], rows[f][1], rows[f][2];
  return out;
}

// Every vertex half way to the area-weighted middle of the triangles around it, back on the
// surface.
void smooth(const Field& field, Surface& surface) {
  Points sum = Points::Zero(surface.vertices.rows(), 3);
  Eigen::VectorXd weight = Eigen::VectorXd::Zero(surface.vertices.rows());
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f) {
    const Vec3 a = surface.vertices.row(surface.triangles(f, 0));
    const Vec3 b = surface.vertices.row(surface.triangles(f, 1));
    const Vec3 c = surface.vertices.row(surface.triangles(f, 2));
    const double area = (b - a).cross(c - a).norm();
    for (int k = 0; k < 3; ++k) {
      sum.row(surface.triangles(f, k)) += area / 3 * (a + b + c).transpose();
      weight[surface.triangles(f, k)] += area;
    }
  }
  for (Eigen::Index v = 0; v < sum.rows(); ++v) {
    const Vec3 here = surface.vertices.row(v);
    const Vec3 middle = sum.row(v).transpose() / weight[v];
    surface.vertices.row(v) = on_surface(field, 0.5 * (here + middle));
  }
}

}  // namespace

Surface mesh_of_field(const Field& field, const ImplicitMeshOptions& options) {
  Surface surface = delaunay_surface(field, options);
  for (int pass = 0; pass < options.smoothing_passes; ++pass) smooth(field, surface);
  return surface;
}

bool crosses_itself(const Surface& surface) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  CGAL::Surface_mesh<Kernel::Point_3> mesh;
  for (Eigen::Index v = 0; v < surface.vertices.rows(); ++v)
    mesh.add_vertex({surface.vertices(v, 0), surface.vertices(v, 1), surface.vertices(v, 2)});
  for (Eigen::Index f = 0; f < surface.triangles.rows(); ++f) {
    using Vertex = CGAL::SM_Vertex_index;
    const auto face = mesh.add_face(Vertex(static_cast<std::uint32_t>(surface.triangles(f, 0))),
                                    Vertex(static_cast<std::uint32_t>(surface.triangles(f, 1))),
                                    Vertex(static_cast<std::uint32_t>(surface.triangles(f, 2))));
    if (!face.is_valid()) return true;  // not a manifold there: two sheets touch
  }
  return CGAL::Polygon_mesh_processing::does_self_intersect(mesh);
}

}  // namespace palpate::bodies
