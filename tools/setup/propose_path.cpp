#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "libfit/assets/asset_file.hpp"
#include "libfit/core/closest_point.hpp"
#include "libfit/core/error.hpp"
#include "libfit/refine/interpolation.hpp"
#include "libfit/refine/points_on_surface.hpp"
#include "tools/setup/propose.hpp"

namespace palpate::tools {
namespace {

constexpr double kRate_Hz = 1000;
constexpr int kStepsPerDepth = 10;  // at which the surface below a slide is looked up
constexpr int kDirections = 12;

/// The asset's surface, and which triangles its test points answer for.
struct PathWindow {
  Surface surface;
  BoxTree boxes;
  std::vector<char> is_measured;  // of a triangle: it can be slid over, and so are all its corners
};

PathWindow window_of(const runtime::AssetView& asset) {
  PathWindow out{palpate::surface_of(asset), {}, {}};
  out.boxes = triangle_boxes(out.surface);
  for (int t = 0; t < asset.triangles; ++t) {
    bool is_measured = asset.is_solid(t);
    for (int k = 0; k < 3; ++k)
      is_measured = is_measured && asset.covered[asset.corner(t, k)] == runtime::kMeasured;
    out.is_measured.push_back(is_measured);
  }
  return out;
}

/// Place and direction in which a tool comes down.
struct Spot {
  Vec3 place, inward;
};

Spot spot_of(const runtime::AssetView& asset, const PathWindow& window,
             const std::vector<Eigen::Index>& corners) {
  Spot spot{Vec3::Zero(), Vec3::Zero()};
  for (const Eigen::Index v : corners) {
    const runtime::Vec3d normal = asset.normal_at(static_cast<int>(v));
    spot.place += window.surface.vertices.row(v) / static_cast<double>(corners.size());
    spot.inward += Vec3(normal.x, normal.y, normal.z);
  }
  spot.inward.normalize();
  return spot;
}

// The vertex among measured triangles alone that is farthest from all others; the first one where
// all are, none where none is.
std::optional<Eigen::Index> middle_vertex(const PathWindow& window) {
  const Triangles& triangles = window.surface.triangles;
  std::vector<char> is_inner(window.surface.vertices.rows(), 0);
  for (const char wanted : {1, 0})
    for (Eigen::Index t = 0; t < triangles.rows(); ++t)
      if (window.is_measured[t] == wanted)
        for (int k = 0; k < 3; ++k) is_inner[triangles(t, k)] = wanted;
  EdgePathSeeds others;
  for (std::size_t v = 0; v < is_inner.size(); ++v)
    if (is_inner[v] == 0) others.push_back({static_cast<std::int32_t>(v), 0});
  const std::vector<double> distance_m = nearest_source(window.surface, {others}).distance_m;
  std::optional<Eigen::Index> best;
  for (std::size_t v = 0; v < is_inner.size(); ++v)
    if (is_inner[v] != 0 && (!best || distance_m[v] > distance_m[*best]))
      best = static_cast<Eigen::Index>(v);
  return best;
}

// In a window too coarse to have such a vertex, the middle of its largest triangle.
Spot middle_of(const runtime::AssetView& asset, const PathWindow& window) {
  if (const auto vertex = middle_vertex(window)) return spot_of(asset, window, {*vertex});
  int largest = -1;
  double largest_m4 = 0;
  for (int t = 0; t < asset.triangles; ++t) {
    const runtime::Vec3d area_m2 = asset.area_vector(t);
    if (window.is_measured[t] == 0 || !(dot(area_m2, area_m2) > largest_m4)) continue;
    largest = t;
    largest_m4 = dot(area_m2, area_m2);
  }
  if (largest < 0)
    throw Error("asset", "no triangle has measured corners alone, so there is nowhere to press",
                "Take a larger region in the scene, or a finer surface.");
  return spot_of(asset, window,
                 {asset.corner(largest, 0), asset.corner(largest, 1), asset.corner(largest, 2)});
}

/// A path over the surface from `spot` along a tangent.
struct Slide {
  Vec3 along = Vec3::Zero();
  double step_m = 0;
  std::vector<double> fall_m{0};  // at 0, 1, 2 ... steps: how far inward the surface lies

  double length_m() const { return step_m * static_cast<double>(fall_m.size() - 1); }
  double fall_at(double path_m) const {
    const double at = step_m > 0 ? path_m / step_m : 0;
    const auto i = std::min(static_cast<std::size_t>(at), fall_m.size() - 1);
    const std::size_t j = std::min(i + 1, fall_m.size() - 1);
    return fall_m[i] + (at - static_cast<double>(i)) * (fall_m[j] - fall_m[i]);
  }
};

// How far a slide along a tangent stays on measured triangles that face the tool; its last step is
// not taken.
Slide slide_along(const PathWindow& window, const Vec3& spot, const Vec3& inward, const Vec3& along,
                  double depth_m) {
  Slide slide{along, depth_m / kStepsPerDepth};
  const auto steps = static_cast<int>(4.0 * kStepsPerDepth);  // in depths: sticks, then slips
  for (int i = 1; i <= steps + 1; ++i) {
    const Vec3 above = spot + i * slide.step_m * along + (slide.fall_m.back() - depth_m) * inward;
    const auto path_m = ray_distance_m(window.surface, window.boxes, above, inward, 0);
    if (!path_m) break;
    const auto hit = closest_point(window.surface, window.boxes, above + *path_m * inward);
    const auto [a, b, c] = corners_of(window.surface, hit->triangle);
    // Within 50 degrees: a slide ends where it gets steeper.
    const bool faces_tool = -(b - a).cross(c - a).normalized().dot(inward) > 0.64;
    if (!faces_tool || window.is_measured[hit->triangle] == 0) break;
    slide.fall_m.push_back(slide.fall_m.back() - depth_m + *path_m);
  }
  if (slide.fall_m.size() > 1) slide.fall_m.pop_back();
  return slide;
}

Slide longest_slide(const PathWindow& window, const Vec3& spot, const Vec3& inward,
                    double depth_m) {
  const Vec3 first = inward.unitOrthogonal(), second = inward.cross(first);
  Slide best;
  for (int k = 0; k < kDirections; ++k) {
    const double angle = 2 * std::numbers::pi * k / kDirections;
    Slide slide = slide_along(window, spot, inward,
                              std::cos(angle) * first + std::sin(angle) * second, depth_m);
    if (slide.fall_m.size() > best.fall_m.size()) best = std::move(slide);
  }
  return best;
}

// From rest to rest in least jerk (Flash and Hogan 1985, doi:10.1523/JNEUROSCI.05-07-01688.1985).
double eased(double share) { return share * share * share * (10 + share * (-15 + 6 * share)); }

}  // namespace

ProposedPath propose_path(const runtime::AssetView& asset) {
  const PathWindow window = window_of(asset);
  const Spot middle = middle_of(asset, window);
  const Vec3 spot = middle.place, inward = middle.inward;
  ProposedPath out;
  out.touched = spot;
  // Neither light nor at the end of what curves were fitted to.
  out.depth_m = 0.6 * asset.max_fitted_m;
  const auto free_m = ray_distance_m(window.surface, window.boxes, spot, -inward,
                                     1e-6 * extent_m(window.surface.vertices).norm());
  const double above_m = std::min(asset.max_fitted_m, free_m ? *free_m / 2 : asset.max_fitted_m);
  const Slide slide = longest_slide(window, spot, inward, out.depth_m);
  out.slide_m = slide.length_m();

  std::vector<Vec3> tips;
  const auto go = [&](double from_m, double to_m, double from_depth_m, double to_depth_m,
                      double time_s) {
    const auto ticks = static_cast<int>(std::lround(time_s * kRate_Hz));
    for (int i = tips.empty() ? 0 : 1; i <= ticks; ++i) {
      const double share = eased(static_cast<double>(i) / ticks);
      const double path_m = from_m + share * (to_m - from_m);
      const double depth_m = from_depth_m + share * (to_depth_m - from_depth_m);
      tips.push_back(spot + path_m * slide.along + (slide.fall_at(path_m) + depth_m) * inward);
    }
  };
  go(0, 0, -above_m, out.depth_m, 0.6);
  go(0, 0, out.depth_m, out.depth_m, 0.2);
  if (out.slide_m > 0) go(0, out.slide_m, out.depth_m, out.depth_m, 1);
  go(out.slide_m, out.slide_m, out.depth_m, -above_m, 0.4);
  out.tip.position.resize(tips.size(), 3);
  for (std::size_t i = 0; i < tips.size(); ++i) {
    out.tip.time_s.push_back(static_cast<double>(i) / kRate_Hz);
    out.tip.position.row(i) = tips[i];
  }
  return out;
}

}  // namespace palpate::tools
