#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "data/generators/bodies.hpp"
#include "data/generators/implicit_mesh.hpp"
#include "libfit/core/error.hpp"

namespace palpate::bodies {
namespace {

constexpr double kDegrees = 180 / 3.14159265358979323846;
constexpr double kSmallestAngle_deg = 20;

Vec3 facet_normal(const Surface& body, Eigen::Index f) {
  const Vec3 a = body.vertices.row(body.triangles(f, 0));
  const Vec3 b = body.vertices.row(body.triangles(f, 1));
  const Vec3 c = body.vertices.row(body.triangles(f, 2));
  return (b - a).cross(c - a).normalized();
}

double smallest_angle_deg(const Surface& body) {
  double smallest = 180;
  for (Eigen::Index f = 0; f < body.triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const Vec3 at = body.vertices.row(body.triangles(f, k));
      const Vec3 e1 = body.vertices.row(body.triangles(f, (k + 1) % 3)).transpose() - at;
      const Vec3 e2 = body.vertices.row(body.triangles(f, (k + 2) % 3)).transpose() - at;
      smallest = std::min(smallest, std::atan2(e1.cross(e2).norm(), e1.dot(e2)) * kDegrees);
    }
  return smallest;
}

}  // namespace

BodyFacts inspect(const std::string& name, const Surface& body_mm) {
  const auto refuse = [&](const std::string& what) {
    throw Error(name, what, "Mend the body's generator; such a mesh must not ship.");
  };
  // Each edge once in either direction: closed and of one orientation.
  std::map<std::pair<std::int32_t, std::int32_t>, Eigen::Index> triangle_of;
  for (Eigen::Index f = 0; f < body_mm.triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const std::pair edge{body_mm.triangles(f, k), body_mm.triangles(f, (k + 1) % 3)};
      if (!triangle_of.emplace(edge, f).second) refuse("two triangles have the same directed edge");
    }
  BodyFacts facts;
  double cosine = 1;
  for (const auto& [edge, f] : triangle_of) {
    const auto twin = triangle_of.find({edge.second, edge.first});
    if (twin == triangle_of.end()) refuse("it is not closed");
    cosine = std::min(cosine, facet_normal(body_mm, f).dot(facet_normal(body_mm, twin->second)));
    facts.mean_edge_mm +=
        (body_mm.vertices.row(edge.first) - body_mm.vertices.row(edge.second)).norm();
  }
  facts.mean_edge_mm /= static_cast<double>(triangle_of.size());
  facts.sharpest_fold_deg = std::acos(std::clamp(cosine, -1.0, 1.0)) * kDegrees;
  facts.extent_mm = extent_m(body_mm.vertices);  // mm in, mm out
  facts.volume_ml = volume_m3(body_mm) / 1e3;
  facts.area_cm2 = area_m2(body_mm) / 1e2;
  facts.smallest_angle_deg = smallest_angle_deg(body_mm);
  if (!(facts.volume_ml > 0)) refuse("it is inside out");
  if (!(facts.smallest_angle_deg > kSmallestAngle_deg)) refuse("a triangle has too small an angle");
  if (crosses_itself(body_mm)) refuse("it crosses itself");
  return facts;
}

}  // namespace palpate::bodies
