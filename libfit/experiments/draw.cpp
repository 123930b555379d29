#include "libfit/experiments/draw.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <random>
#include <tuple>
#include <utility>

#include "libfit/core/closest_point.hpp"
#include "libfit/core/error.hpp"

namespace palpate {
namespace {

constexpr int kPressRows = 6;                       // of a straight or oblique press
constexpr int kSlidingRows = 9;                     // the last two thirds slide
constexpr int kWaypoints = 6, kRowsToWaypoint = 2;  // after a press of as many rows
constexpr double kDeepest = 0.95;                   // of the range
constexpr int kMaxTurns = 32;  // directions tried for a slide that stays where one can reach

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

struct ReachableArea {
  std::vector<Eigen::Index> triangle;
  std::vector<double> sum_m2;  ///< running
};

double area_m2(const Surface& surface, Eigen::Index t) {
  const auto [a, b, c] = corners_of(surface, t);
  return 0.5 * (b - a).cross(c - a).norm();
}

ReachableArea reachable_area(const Body& body, const std::vector<double>& change) {
  ReachableArea area;
  double sum = 0;
  for (Eigen::Index t = 0; t < body.surface.triangles.rows(); ++t) {
    const auto corner = body.surface.triangles.row(t);
    bool is_reachable = true;
    for (int k = 0; k < 3; ++k) is_reachable = is_reachable && body.is_reachable[corner[k]];
    if (!is_reachable) continue;
    sum += area_m2(body.surface, t);
    area.triangle.push_back(t);
    area.sum_m2.push_back(sum);
  }
  if (!change.empty()) {
    std::ranges::stable_sort(area.triangle, std::greater(), [&](auto t) { return change[t]; });
    const double most_m2 = sum / 5;
    sum = 0;
    area.sum_m2.clear();
    for (const Eigen::Index t : area.triangle)
      if (sum < most_m2) area.sum_m2.push_back(sum += area_m2(body.surface, t));
    area.triangle.resize(area.sum_m2.size());
  }
  if (area.triangle.empty() || !(sum > 0))
    throw Error("validate", "no triangle of the body can be reached",
                "Widen the region of [experiments].");
  return area;
}

// A point uniform by area, and the blended inward normal there.
std::pair<Vec3, Vec3> draw_point(const Body& body, const ReachableArea& area, const Points& outward,
                                 Uniform& uniform) {
  const double at = uniform(0, area.sum_m2.back());
  const auto found = std::upper_bound(area.sum_m2.begin(), area.sum_m2.end() - 1, at);
  const auto corner = body.surface.triangles.row(area.triangle[found - area.sum_m2.begin()]);
  const double root = std::sqrt(uniform(0, 1)), split = uniform(0, 1);
  const double weight[3] = {1 - root, root * (1 - split), root * split};
  Vec3 position = Vec3::Zero(), normal = Vec3::Zero();
  for (int k = 0; k < 3; ++k) {
    position += weight[k] * body.surface.vertices.row(corner[k]).transpose();
    normal -= weight[k] * outward.row(corner[k]).transpose();
  }
  return {position, normal.normalized()};
}

// Tells if the contact point stays reachable where a tip has moved to.
class Reach {
 public:
  explicit Reach(const Body& body) : body_(body), boxes_(triangle_boxes(body.surface)) {}
  bool holds(const Vec3& place) const {
    const auto hit = closest_point(body_.surface, boxes_, place);
    const auto corner = body_.surface.triangles.row(hit->triangle);
    for (int k = 0; k < 3; ++k)
      if (!body_.is_reachable[corner[k]]) return false;
    return true;
  }

 private:
  const Body& body_;
  BoxTree boxes_;
};

Vec3 tangent_of(const Vec3& normal, double angle_rad) {
  const Vec3 first = normal.unitOrthogonal();
  return std::cos(angle_rad) * first + std::sin(angle_rad) * normal.cross(first);
}

// Rows of depth and travel, from first touch on [m].
std::vector<std::pair<double, double>> depth_and_travel(PathKind kind, double depth, double slope,
                                                        double drag) {
  std::vector<std::pair<double, double>> rows;
  const auto press = [&](int count, double lean) {
    for (int k = 1; k <= count; ++k) rows.emplace_back(depth * k / count, lean * depth * k / count);
  };
  switch (kind) {
    case PathKind::straight:
      press(kPressRows, 0);
      break;
    case PathKind::oblique:
      press(kPressRows, slope);
      break;
    case PathKind::sliding:
      for (int k = 1; k <= kSlidingRows; ++k)
        rows.emplace_back(depth * k / kSlidingRows,
                          drag * std::max(0, 3 * k - kSlidingRows) / (2.0 * kSlidingRows));
      break;
    case PathKind::back_and_forth:
      press(4, 0);
      for (int k = 1; k <= 4; ++k) rows.emplace_back(depth, drag * k / 4);
      for (int k = 1; k <= 6; ++k)  // half of the drag past where it began
        rows.emplace_back(depth, drag - drag * 1.5 * k / 6);
      break;
    case PathKind::tilting:  // its motion is of another kind
    case PathKind::wandering:
    case PathKind::none:
      break;  // leaves the plane: wandering_path
  }
  return rows;
}

// Beyond the region no test point answers: a slide that ends there compares nothing. The angle is
// turned until the contact point, wherever it goes, can be reached; left as drawn if it never can.
Vec3 direction_of(const std::vector<std::pair<double, double>>& rows, const Vec3& position,
                  const Vec3& normal, double angle_rad, const Reach& reach) {
  double min_travel = 0, max_travel = 0;
  for (const auto& [depth, travel] : rows) {
    min_travel = std::min(min_travel, travel);
    max_travel = std::max(max_travel, travel);
  }
  for (int turn = 0; turn < kMaxTurns; ++turn) {
    const Vec3 tangent = tangent_of(normal, angle_rad + 2 * std::numbers::pi * turn / kMaxTurns);
    if (reach.holds(position + min_travel * tangent) &&
        reach.holds(position + max_travel * tangent))
      return tangent;
  }
  return tangent_of(normal, angle_rad);
}

Points wandering_path(const Vec3& position, const Vec3& normal, const HeldOutRange& range,
                      const Reach& reach, Uniform& uniform) {
  Points path((kWaypoints + 1) * kRowsToWaypoint, 3);
  double share = uniform(0.5, kDeepest);
  Vec3 from = Vec3::Zero(), to = range.depth_m * share * normal;
  Eigen::Index row = 0;
  for (int waypoint = 0; waypoint <= kWaypoints; ++waypoint) {
    for (int k = 1; k <= kRowsToWaypoint; ++k)
      path.row(row++) = from + (to - from) * k / kRowsToWaypoint;
    from = to;
    share = waypoint % 2 == 0 ? uniform(0.2, share) : uniform(share, kDeepest);
    Vec3 travel = Vec3::Zero();  // back to the middle where no place can be reached
    for (int turn = 0; turn < kMaxTurns; ++turn) {
      const double away = range.drag_distance_m * std::sqrt(uniform(0, 1));
      const Vec3 wanted = away * tangent_of(normal, uniform(0, 2 * std::numbers::pi));
      if (!reach.holds(position + wanted)) continue;
      travel = wanted;
      break;
    }
    to = range.depth_m * share * normal + travel;
  }
  return path;
}

Points draw_path(PathKind kind, const Vec3& position, const Vec3& normal, const HeldOutRange& range,
                 const Reach& reach, Uniform& uniform) {
  if (kind == PathKind::wandering) return wandering_path(position, normal, range, reach, uniform);
  const double angle_rad = uniform(0, 2 * std::numbers::pi);
  const double depth = range.depth_m * uniform(0.5, kDeepest);
  const double slope = std::tan(uniform(20, 45) * std::numbers::pi / 180);
  const double drag = range.drag_distance_m * uniform(0.5, 1);
  const auto rows = depth_and_travel(kind, depth, slope, drag);
  const Vec3 tangent = direction_of(rows, position, normal, angle_rad, reach);
  Points path(rows.size(), 3);
  for (std::size_t k = 0; k < rows.size(); ++k)
    path.row(k) = rows[k].first * normal + rows[k].second * tangent;
  return path;
}

// Two places of the region, and the blended inward normals there.
struct TwoPlaces {
  Vec3 position, normal, other, other_normal;
};

// Draws experiments for validation, one after the other.
class PathDrawer {
 public:
  PathDrawer(const Body& body, const HeldOutRange& range, std::uint64_t seed)
      : body_(body),
        range_(range),
        area_(reachable_area(body, range.change)),
        reach_(body),
        outward_(vertex_normals(body.surface)),
        uniform_(seed) {
    out_.points.triangles.resize(0, 3);
  }

  void add(PathKind kind, PathKind motion, bool tilts, char name = 'v') {
    Vec3 position, normal;
    Lean lean = Lean::Zero();
    const auto can_touch = [&] {
      return tilts ? !range_.can_lean || range_.can_lean(position, normal, lean)
                   : !range_.can_touch || range_.can_touch(position, normal);
    };
    int draws = 0;
    do {
      if (draws++ == 1000)
        throw Error("validate", "the tool can touch at no point of the region that was drawn",
                    "Widen the region of [experiments], or take a smaller tool.");
      std::tie(position, normal) = draw_point(body_, area_, outward_, uniform_);
      if (tilts) lean = lean_of(uniform_(0, range_.tilt_rad), uniform_(0, 2 * std::numbers::pi));
    } while (!can_touch());
    const auto i = static_cast<std::int32_t>(out_.paths.size());
    out_.points.add(position, normal, fmt::format("{}{:04}", name, i + 1));
    ToolPath& path = out_.paths.emplace_back();
    path = {i, draw_path(motion, position, normal, range_, reach_, uniform_), {}, lean};
    path.kind = kind;
  }

  // share: of the distances from the least to the largest; none: drawn.
  void add_pair(double least_m, double most_m, std::optional<double> share) {
    const double wanted_m = least_m * std::pow(most_m / least_m, share ? *share : uniform_(0, 1));
    const TwoPlaces at = draw_places(least_m, wanted_m);
    const auto i = static_cast<std::int32_t>(out_.paths.size());
    out_.paths.push_back(draw_pair(i, at));
    out_.points.add(at.position, at.normal, fmt::format("t{:04}", i + 1));
  }
  HeldOut done() { return std::move(out_); }

 private:
  // As far apart as wanted, as nearly as 400 draws come to it.
  TwoPlaces draw_places(double least_m, double wanted_m) {
    TwoPlaces best;
    double best_m = kInfinity;
    for (int place = 0; place < 400; ++place) {
      const auto [p, u] = draw_point(body_, area_, outward_, uniform_);
      const auto [q, v] = draw_point(body_, area_, outward_, uniform_);
      const double away_m = (p - q).norm();
      if (away_m < least_m || u.dot(v) < 0.5 || !(std::abs(away_m - wanted_m) < best_m) ||
          (range_.can_touch && !(range_.can_touch(p, u) && range_.can_touch(q, v))))
        continue;
      best_m = std::abs(away_m - wanted_m);
      best = {p, u, q, v};
    }
    if (!std::isfinite(best_m))
      throw Error("pairs",
                  fmt::format("no two places of the region are {:.3g} mm apart where the "
                              "tools can touch",
                              1e3 * least_m),
                  "Widen the region of [experiments], or take a smaller tool.");
    return best;
  }

  // The second tool presses, then the first beside it, and one of them is dragged.
  ToolPath draw_pair(std::int32_t point, const TwoPlaces& at) {
    // Rows: depths of both over their deepest, travel of the one that is dragged over its distance.
    constexpr double kRows[][3] = {{-0.1, 0.5, 0}, {-0.1, 1, 0}, {0.4, 1, 0}, {0.7, 1, 0},
                                   {1, 1, 0},      {1, 1, 0.2},  {1, 1, 0.5}, {1, 1, 1}};
    constexpr auto kCount = static_cast<Eigen::Index>(std::size(kRows));
    const bool is_first_dragged = point % 2 == 0;
    const double depth = range_.depth_m * uniform_(0.4, kDeepest),
                 other_depth = range_.depth_m * uniform_(0.4, kDeepest);
    const double drag = range_.drag_distance_m * uniform_(0.5, 1);
    const Vec3 &from = is_first_dragged ? at.position : at.other,
               &along = is_first_dragged ? at.normal : at.other_normal;
    // Away from the other tool or beside it.
    const Vec3 apart =
        is_first_dragged ? Vec3(at.position - at.other) : Vec3(at.other - at.position);
    Vec3 tangent = Vec3::Zero();
    for (int turn = 0; turn < kMaxTurns && tangent.isZero(); ++turn) {
      const Vec3 tried = tangent_of(along, uniform_(0, 2 * std::numbers::pi));
      if (tried.dot(apart) >= 0 && reach_.holds(from + drag * tried)) tangent = tried;
    }
    ToolPath path{point, Points(kCount, 3)};
    path.second = SecondTool{at.other, at.other_normal, Points(kCount, 3)};
    for (Eigen::Index k = 0; k < kCount; ++k) {
      const Vec3 travel = drag * kRows[k][2] * tangent;
      path.deflections.row(k) = kRows[k][0] * depth * at.normal;
      path.second->deflections.row(k) = kRows[k][1] * other_depth * at.other_normal;
      (is_first_dragged ? path.deflections : path.second->deflections).row(k) += travel.transpose();
    }
    return path;
  }

  const Body& body_;
  const HeldOutRange& range_;
  ReachableArea area_;
  Reach reach_;
  Points outward_;
  Uniform uniform_;
  HeldOut out_;
};

constexpr int kKinds = static_cast<int>(kUprightKinds);

}  // namespace

HeldOut draw_held_out(const Body& body, const HeldOutRange& range, int points, std::uint64_t seed) {
  const int all = points + (range.tilt_rad > 0 ? (points + kKinds - 1) / kKinds : 0);
  PathDrawer drawing(body, range, seed);
  for (int i = 0; i < all; ++i) {
    const auto kind = static_cast<PathKind>(i % kKinds);
    if (i < points)
      drawing.add(kind, kind, false);
    else
      drawing.add(PathKind::tilting, i % 2 == 0 ? PathKind::straight : PathKind::sliding, true);
  }
  return drawing.done();
}

HeldOut draw_sliding(const Body& body, const HeldOutRange& range, int paths, std::uint64_t seed) {
  PathDrawer drawing(body, range, seed);
  for (int i = 0; i < paths; ++i) {
    const PathKind kind = i % 2 == 0 ? PathKind::back_and_forth : PathKind::wandering;
    drawing.add(kind, kind, false, kChangeName);
  }
  return drawing.done();
}

HeldOut draw_leaning(const Body& body, const HeldOutRange& range, int paths, std::uint64_t seed) {
  PathDrawer drawing(body, range, seed);
  for (int i = 0; i < paths; ++i) {
    const auto kind = static_cast<PathKind>(i % kKinds);
    drawing.add(kind, kind, true);
  }
  return drawing.done();
}

HeldOut draw_two_tools(const Body& body, const HeldOutRange& range, int paths, double least_m,
                       double most_m, bool is_drawn, std::uint64_t seed) {
  PathDrawer drawing(body, range, seed);
  for (int i = 0; i < paths; ++i)
    drawing.add_pair(least_m, most_m,
                     is_drawn ? std::nullopt : std::optional<double>((i + 0.5) / paths));
  return drawing.done();
}

}  // namespace palpate
