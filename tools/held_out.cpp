#include "tools/held_out.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "libfit/core/error.hpp"

namespace palpate::tools {
namespace {

constexpr int kPressRows = 6;
constexpr int kDragRows = 6;

// std::uniform_real_distribution may differ between libraries; this does not.
class Uniform {
 public:
  explicit Uniform(std::uint64_t seed) : random_(seed) {}
  double operator()(double low, double high) {
    return low + (high - low) * static_cast<double>(random_() >> 11) * 0x1p-53;
  }

 private:
  std::mt19937_64 random_;
};

Vec3 eigen(const runtime::Vec3d& v) { return {v.x, v.y, v.z}; }

struct CoveredArea {
  std::vector<int> triangle;
  std::vector<double> sum_m2;  ///< running
};

CoveredArea covered_area(const runtime::AssetView& asset) {
  CoveredArea area;
  double sum = 0;
  for (int t = 0; t < asset.triangles; ++t) {
    const bool is_covered = asset.is_solid(t) && asset.covered[asset.corner(t, 0)] &&
                            asset.covered[asset.corner(t, 1)] && asset.covered[asset.corner(t, 2)];
    if (!is_covered) continue;
    sum += 0.5 * eigen(asset.area_vector(t)).norm();
    area.triangle.push_back(t);
    area.sum_m2.push_back(sum);
  }
  if (area.triangle.empty() || !(sum > 0))
    throw Error("asset", "no triangle is covered by curves",
                "Fit and refine more test points before validating.");
  return area;
}

Vec3 tangent_of(const Vec3& normal, double angle_rad) {
  const Vec3 first = normal.unitOrthogonal();
  return std::cos(angle_rad) * first + std::sin(angle_rad) * normal.cross(first);
}

Points draw_path(int kind, const Vec3& normal, const HeldOutRange& range, Uniform& uniform) {
  const Vec3 tangent = tangent_of(normal, uniform(0, 2 * std::numbers::pi));
  const double depth = range.depth_m * uniform(0.5, 0.95);
  const double slope = std::tan(uniform(20, 45) * std::numbers::pi / 180);
  const double drag = range.drag_distance_m * uniform(0.5, 1);
  const bool is_drag = kind == 2, is_oblique = kind == 1;
  Points path(kPressRows + (is_drag ? kDragRows : 0), 3);
  for (int k = 0; k < kPressRows; ++k) {
    const double d = depth * (k + 1) / kPressRows;
    path.row(k) = d * normal + (is_oblique ? slope * d : 0.0) * tangent;
  }
  for (int k = kPressRows; k < path.rows(); ++k)
    path.row(k) = depth * normal + drag * (k - kPressRows + 1) / kDragRows * tangent;
  return path;
}

}  // namespace

HeldOut draw_held_out(const runtime::AssetView& asset, const HeldOutRange& range, int points,
                      std::uint64_t seed) {
  const CoveredArea area = covered_area(asset);
  Uniform uniform(seed);
  HeldOut out;
  out.points.position.resize(points, 3);
  out.points.normal.resize(points, 3);
  for (int i = 0; i < points; ++i) {
    const double at = uniform(0, area.sum_m2.back());
    const auto found = std::upper_bound(area.sum_m2.begin(), area.sum_m2.end() - 1, at);
    const int t = area.triangle[static_cast<std::size_t>(found - area.sum_m2.begin())];
    const double root = std::sqrt(uniform(0, 1)), split = uniform(0, 1);
    const double weight[3] = {1 - root, root * (1 - split), root * split};
    Vec3 position(asset.origin_m[0], asset.origin_m[1], asset.origin_m[2]), normal = Vec3::Zero();
    for (int k = 0; k < 3; ++k) {
      position += weight[k] * eigen(asset.vertex_at(asset.corner(t, k)));
      normal += weight[k] * eigen(asset.normal_at(asset.corner(t, k)));
    }
    normal.normalize();
    out.points.position.row(i) = position;
    out.points.normal.row(i) = normal;
    out.points.name.push_back(fmt::format("v{:04}", i + 1));
    out.paths.push_back({i, draw_path(i % 3, normal, range, uniform)});
  }
  return out;
}

}  // namespace palpate::tools
