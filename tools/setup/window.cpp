#include "tools/setup/propose.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include "libfem/mesh/repair/facts.hpp"
#include "libfem/probes/probes.hpp"
#include "libfem/probes/reach.hpp"
#include "libfit/core/closest_point.hpp"
#include "libfit/core/perception.hpp"
#include "tools/scene/region.hpp"

namespace palpate::tools {
namespace {

constexpr double kHeldShare = 0.25;      // of the surface's area; less and the organ sways
constexpr double kFacing = 0.7;          // cosine to a side of what lies flat on it
constexpr double kProbeShare = 1.0 / 8;  // of the thickness; presses go one radius deep

struct TriangleArea {
  Vec3 centre, area;  // area: along the outward normal [m^2]
};

std::vector<TriangleArea> areas_of(const Surface& surface) {
  std::vector<TriangleArea> facets;
  for (const auto& corner : surface.triangles.rowwise()) {
    const Vec3 a = surface.vertices.row(corner[0]), b = surface.vertices.row(corner[1]),
               c = surface.vertices.row(corner[2]);
    facets.push_back({(a + b + c) / 3, (b - a).cross(c - a) / 2});
  }
  return facets;
}

// True if a facet is in the window and a tool can press on it.
bool is_pressed(const TriangleArea& facet, const Window& window) {
  return (facet.centre - window.centre).norm() <= window.radius_m &&
         -facet.area.dot(window.outward()) > kFacing * facet.area.norm();
}

// Where the held part of a side begins, and the share of it that faces the side.
double hold(const std::vector<TriangleArea>& facets, Window& window) {
  std::vector<std::array<double, 3>> faces;  // height, area, area where it faces the side
  double total = 0;
  for (const TriangleArea& facet : facets) {
    const double area = facet.area.norm();
    const bool faces_it = facet.area.dot(window.outward()) > kFacing * area;
    faces.push_back({window.outward().dot(facet.centre), area, faces_it ? area : 0});
    total += area;
  }
  std::sort(faces.begin(), faces.end(), std::greater<>());
  double held = 0, resting = 0;
  for (const auto& [height, area, faces_it] : faces) {
    window.held_m = window.sign * height;
    resting += faces_it;
    if ((held += area) >= kHeldShare * total) break;
  }
  return resting / (kHeldShare * total);
}

// Where a line through the middle of the body, against the held side, enters it.
void place(const Surface& surface, const BoxTree& boxes, Window& window) {
  const Vec3 up = -window.outward();
  const Vec3 low = surface.vertices.colwise().minCoeff(),
             high = surface.vertices.colwise().maxCoeff();
  Vec3 above = surface.vertices.colwise().mean();
  above[window.axis] = up[window.axis] > 0 ? high[window.axis] : low[window.axis];
  above += 1e-3 * (high - low).norm() * up;
  // The nearest place of the surface stands in where the line misses it, as on a ring.
  const auto hit = ray_distance_m(surface, boxes, above, -up, 0);
  window.centre = hit ? Vec3(above - *hit * up) : closest_point(surface, boxes, above)->position;
  Vec3 across = high - low;
  across[window.axis] = std::numeric_limits<double>::infinity();
  window.radius_m = rounded_m(0.22 * across.minCoeff());
}

// Share of the window's area that looks away from the held side, so that a tool can press on it.
double facing_share(const std::vector<TriangleArea>& facets, const Window& window) {
  double all = 0, facing = 0;
  for (const TriangleArea& facet : facets) {
    if ((facet.centre - window.centre).norm() > window.radius_m) continue;
    all += facet.area.norm();
    if (is_pressed(facet, window)) facing += facet.area.norm();
  }
  return all > 0 ? facing / all : 0;
}

}  // namespace

double rounded_m(double length_m) {
  const double step = std::pow(10, std::floor(std::log10(length_m)) - 1);
  return std::round(length_m / step) * step;
}

std::string Window::side() const { return {sign < 0 ? '-' : '+', "xyz"[axis]}; }

std::vector<Window> windows_of(const Surface& surface, std::string_view held) {
  const BoxTree boxes = triangle_boxes(surface);
  const std::vector<TriangleArea> facets = areas_of(surface);
  std::vector<std::pair<double, Window>> scored;
  for (const std::string_view name : kSides) {
    if (!held.empty() && name != held) continue;
    Window window{name[1] - 'x', name[0] == '-' ? -1.0 : 1.0};
    const double resting = hold(facets, window);
    place(surface, boxes, window);
    scored.emplace_back(facing_share(facets, window) + 0.5 * resting, window);
  }
  // A side that is hardly better than one before it in the table does not come before it.
  std::vector<Window> windows;
  while (!scored.empty()) {
    auto best = scored.begin();
    for (auto it = scored.begin(); it != scored.end(); ++it)
      if (it->first > best->first + 0.05) best = it;
    windows.push_back(best->second);
    scored.erase(best);
  }
  return windows;
}

std::vector<char> vertices_in(const Window& window, const Surface& surface) {
  const Points normals = vertex_normals(surface);
  std::vector<char> is_in(surface.vertices.rows(), 0);
  for (Eigen::Index v = 0; v < surface.vertices.rows(); ++v) {
    const Vec3 place = surface.vertices.row(v);
    is_in[v] = (place - window.centre).norm() <= window.radius_m &&
               window.sign * (place[window.axis] - window.held_m) < 0 &&
               normals.row(v).dot(window.outward()) < 0;
  }
  return is_in;
}

double thickness_under_m(const Window& window, const Surface& with_lumens) {
  const Surface surface = outer_surface(with_lumens);
  const BoxTree boxes = triangle_boxes(surface);
  const double skip_m = 1e-6 * extent_m(surface.vertices).norm();
  std::vector<std::pair<double, double>> thick;  // and the area that has it
  double total = 0;
  for (const TriangleArea& facet : areas_of(surface)) {
    if (!is_pressed(facet, window)) continue;
    const Vec3 inward = -facet.area.normalized();
    const auto through =
        ray_distance_m(surface, boxes, facet.centre - skip_m * inward, inward, 2 * skip_m);
    if (!through) continue;
    thick.emplace_back(*through - skip_m, facet.area.norm());
    total += facet.area.norm();
  }
  std::sort(thick.begin(), thick.end());
  double sum = 0;
  for (const auto& [thickness_m, area] : thick)
    if ((sum += area) >= total / 2) return thickness_m;
  return 0;
}

std::optional<ProposedBall> ball_for(const Window& window, const Surface& surface, double young_Pa,
                                     double poisson) {
  const double thickness_m = thickness_under_m(window, surface);
  // Across, too: the rim of a sheet is as thick as the sheet is wide.
  // A thinner sheet takes minutes to fill.
  const double thinnest_m = 1.0 / 300 * extent_m(surface.vertices).maxCoeff();
  if (!(thickness_m > thinnest_m && window.radius_m > thinnest_m)) return std::nullopt;
  // Hertz with the contact radius sqrt(R d): F = 4/3 E* sqrt(R) d^1.5, of d = R at the end. Rows
  // are to be felt from 3/7 of the depth on.
  const double hertz_Pa = 4.0 / 3 * young_Pa / (1 - poisson * poisson);
  const double felt_m = std::sqrt(perception().force_floor_N / (hertz_Pa * std::pow(3.0 / 7, 1.5)));
  const double first_m = std::min({std::max(std::min(kProbeShare * thickness_m, 0.01), felt_m),
                                   1.0 / 4 * thickness_m, window.radius_m / 3});
  const std::vector<char> is_in = vertices_in(window, surface);
  const auto all = std::count(is_in.begin(), is_in.end(), 1);
  const Points outward = vertex_normals(surface);
  for (double radius_m = first_m; radius_m > 0.3 * first_m; radius_m *= 0.8) {
    ProposedBall ball;
    ball.radius_m = rounded_m(radius_m);
    ball.force_N = hertz_Pa * ball.radius_m * ball.radius_m;
    const fem::ToolReach reach(surface, fem::make_probe(sphere_spec(ball.radius_m), "[probe]"),
                               0.1 * ball.radius_m);  // as find_reachable has it
    const std::vector<char> is_reached = reach.vertices(is_in, outward);
    ball.reachable = static_cast<int>(std::count(is_reached.begin(), is_reached.end(), 1));
    if (ball.reachable >= 12 && ball.reachable >= 0.5 * static_cast<double>(all)) return ball;
  }
  return std::nullopt;
}

}  // namespace palpate::tools
