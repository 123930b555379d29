#include "libfem/probes/reach.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "libfem/mesh/topology.hpp"

namespace palpate::fem {
namespace {

constexpr std::size_t kPlacesOfPatch = 200;  // from where exits are tried, where no normal is one

}  // namespace

ToolReach::ToolReach(const Surface& closed, Probe probe, double tolerance_m)
    : surface_(closed),
      boxes_(triangle_boxes(closed)),
      low_(closed.vertices.colwise().minCoeff()),
      high_(closed.vertices.colwise().maxCoeff()),
      probe_(std::move(probe)),
      tolerance_m_(tolerance_m),
      resolution_m_(tolerance_m / 4) {}

double ToolReach::overlap_with_triangle_m(const Probe& probe, const Vec3& position,
                                          const Vec3& inward, std::int32_t triangle,
                                          double least_m) const {
  std::vector<std::array<Vec3, 3>> parts{corners_of(surface_, triangle)};
  while (!parts.empty()) {
    const auto [a, b, c] = parts.back();
    parts.pop_back();
    const Vec3 middle = (a + b + c) / 3;
    const double radius = std::sqrt(std::max(
        {(a - middle).squaredNorm(), (b - middle).squaredNorm(), (c - middle).squaredNorm()}));
    if (-probe.min_distance_m(inward, middle - position) + radius <= least_m + resolution_m_)
      continue;
    const SignedDistance at = probe.distance(inward, middle - position);
    least_m = std::max(least_m, -at.distance_m);
    // A distance changes by no more than the path; that to a convex shape by no less than its
    // slope.
    double fall = radius;
    if (!probe.shape->takes_mesh && at.gradient.squaredNorm() > 0.5)
      fall = std::max(
          {at.gradient.dot(middle - a), at.gradient.dot(middle - b), at.gradient.dot(middle - c)});
    if (fall - at.distance_m <= least_m + resolution_m_) continue;
    const std::array<Vec3, 3> corner{a, b, c};
    std::size_t k = 0;  // the longest edge is k, k + 1
    for (std::size_t e = 1; e < 3; ++e)
      if ((corner[e] - corner[(e + 1) % 3]).squaredNorm() >
          (corner[k] - corner[(k + 1) % 3]).squaredNorm())
        k = e;
    const Vec3 half = (corner[k] + corner[(k + 1) % 3]) / 2;
    parts.push_back({corner[k], half, corner[(k + 2) % 3]});
    parts.push_back({half, corner[(k + 1) % 3], corner[(k + 2) % 3]});
  }
  return least_m;
}

double ToolReach::overlap_m(const Vec3& position, const Vec3& inward, const Lean& lean) const {
  const Probe leaning = lean.isZero() ? Probe() : tilted(probe_, inward, lean, "[probe]");
  const Probe& probe = lean.isZero() ? probe_ : leaning;
  // A place within the tool: its middle, or just behind the tip. How deep it lies in the tool and
  // in the body is a lower bound, and exact of a ball's middle.
  Vec3 core = probe.ball.along_axis_m * inward;
  if (probe.leans || !std::isfinite(probe.ball.radius_m) ||
      !(probe.distance(inward, core).distance_m < -tolerance_m_))
    core = -2 * tolerance_m_ * inward;
  const double depth_in_tool = -probe.distance(inward, core).distance_m;
  const double to_surface = closest_point(surface_, boxes_, position + core)->distance_m;
  const bool is_in_body = is_inside(surface_, boxes_, position + core);
  double overlap = std::max(0.0, depth_in_tool + (is_in_body ? to_surface : -to_surface));
  boxes_.visit_where(
      [&](const Vec3& centre, double radius) {
        return radius - probe.min_distance_m(inward, centre - position) > overlap + resolution_m_;
      },
      [&](std::int32_t f) {
        overlap = overlap_with_triangle_m(probe, position, inward, f, overlap);
      });
  return overlap;
}

bool ToolReach::passes(Vec3 centre, const Vec3& direction, double length_m) const {
  const double radius = ball_radius_m();
  for (double gone = 0; gone < length_m;) {
    if (((centre - low_).array() < -radius).any() || ((high_ - centre).array() < -radius).any())
      return true;
    const double distance = closest_point(surface_, boxes_, centre)->distance_m;
    // An exit must leave room for 0.8 of the ball, whose steps are a tenth of it or more.
    if (distance < 0.8 * radius) return false;
    const double step = std::max(distance - radius, 0.1 * radius);
    centre += step * direction;
    gone += step;
  }
  return true;
}

bool ToolReach::can_leave(const std::vector<Vec3>& centres,
                          const std::vector<Vec3>& outside) const {
  // To the faces, edges and corners of a cube: exits that are tried beside the normal.
  static const std::vector<Vec3> kDirections = [] {
    std::vector<Vec3> directions;
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z)
          if (x != 0 || y != 0 || z != 0) directions.push_back(Vec3(x, y, z).normalized());
    return directions;
  }();
  constexpr double kFar = std::numeric_limits<double>::infinity();
  for (const Vec3& centre : centres) {
    if (std::any_of(kDirections.begin(), kDirections.end(),
                    [&](const Vec3& direction) { return passes(centre, direction, kFar); }))
      return true;
    std::vector<std::pair<double, std::size_t>> nearest;
    for (std::size_t i = 0; i < outside.size(); ++i)
      nearest.emplace_back((outside[i] - centre).squaredNorm(), i);
    // The three nearest places with an exit are tried.
    const std::size_t tried = std::min(std::size_t{3}, nearest.size());
    std::partial_sort(nearest.begin(), nearest.begin() + tried, nearest.end());
    for (std::size_t i = 0; i < tried; ++i) {
      const Vec3 direction = outside[nearest[i].second] - centre;
      if (passes(centre, direction.normalized(), direction.norm())) return true;
    }
  }
  return false;
}

void ToolReach::drop_enclosed(const Points& outward, std::vector<char>& is_reached) const {
  struct FreePatch {
    std::vector<std::int32_t> vertices;
    std::vector<Vec3> centres;  // of some of them, of the ball that touches there
    bool is_out = false;
  };
  std::vector<FreePatch> patches;
  std::vector<Vec3> outside;  // centres of patches that have an exit
  const auto found_out = [&](FreePatch& patch) {
    patch.is_out = true;
    outside.insert(outside.end(), patch.centres.begin(), patch.centres.end());
  };
  constexpr double kFar = std::numeric_limits<double>::infinity();
  for (auto& vertices : patches_of(surface_, is_reached)) {
    FreePatch& patch = patches.emplace_back(FreePatch{std::move(vertices), {}});
    const std::size_t stride = (patch.vertices.size() + kPlacesOfPatch - 1) / kPlacesOfPatch;
    for (std::size_t i = 0; i < patch.vertices.size(); i += stride)
      patch.centres.push_back(surface_.vertices.row(patch.vertices[i]).transpose() +
                              ball_radius_m() * outward.row(patch.vertices[i]).transpose());
    if (std::any_of(patch.vertices.begin(), patch.vertices.end(), [&](std::int32_t v) {
          const Vec3 normal = outward.row(v), vertex = surface_.vertices.row(v);
          return passes(vertex + ball_radius_m() * normal, normal, kFar);
        }))
      found_out(patch);
  }
  for (bool is_changed = true; is_changed;) {
    is_changed = false;
    for (FreePatch& patch : patches) {
      if (patch.is_out || !can_leave(patch.centres, outside)) continue;
      found_out(patch);
      is_changed = true;
    }
  }
  for (const FreePatch& patch : patches)
    if (!patch.is_out)
      for (const std::int32_t v : patch.vertices) is_reached[v] = 0;
}

std::vector<char> ToolReach::vertices(const std::vector<char>& is_candidate, const Points& outward,
                                      std::vector<double>* overlap) const {
  std::vector<char> is_reached(is_candidate.size(), 0);
  if (overlap != nullptr) overlap->assign(is_candidate.size(), 0);
  for (std::size_t v = 0; v < is_candidate.size(); ++v) {
    const auto row = static_cast<Eigen::Index>(v);
    if (!is_candidate[v] || !(outward.row(row).squaredNorm() > 0)) continue;
    const double cut = overlap_m(surface_.vertices.row(row), -outward.row(row));
    if (overlap != nullptr) (*overlap)[v] = cut;
    is_reached[v] = cut <= tolerance_m_;
  }
  if (std::isfinite(probe_.ball.radius_m)) drop_enclosed(outward, is_reached);
  return is_reached;
}

}  // namespace palpate::fem
