#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tools/stages/samples/placement.hpp"

namespace palpate::tools {
namespace {

struct Pressed {
  std::size_t point = 0;
  double force_N = 0;
  double lean = 0;  // of the deepest row: tangential over normal force
  bool is_whole = true;
};

std::vector<Pressed> deepest_rows(const Samples& presses) {
  std::vector<Pressed> out(presses.points());
  for (std::size_t p = 0; p < out.size(); ++p) out[p].point = p;
  for (Eigen::Index row = 0; row < presses.rows(); ++row) {
    Pressed& point = out[presses.point[row]];
    if (presses.status[row] != RowStatus::good) point.is_whole = false;
    const Vec3 force = presses.force.row(row),
               normal = presses.point_normal.row(presses.point[row]);
    if (!(force.norm() > point.force_N)) continue;
    point.force_N = force.norm();
    const double pressed_N = force.dot(normal);
    point.lean = pressed_N > 0 ? (force - pressed_N * normal).norm() / pressed_N
                               : std::numeric_limits<double>::infinity();
  }
  std::erase_if(out, [](const Pressed& point) { return !(point.force_N > 0); });
  return out;
}

}  // namespace

std::vector<std::size_t> points_to_drag(const Samples& presses) {
  std::vector<Pressed> points = deepest_rows(presses);
  std::ranges::stable_sort(points, {}, &Pressed::force_N);
  const std::size_t groups = std::min(kFirstDrags, points.size());
  std::vector<std::size_t> out;
  for (std::size_t k = 0; k < groups; ++k) {
    const auto at = [&](std::size_t group) {
      return points.begin() + static_cast<std::ptrdiff_t>(group * points.size() / groups);
    };
    const auto rank = [&](const Pressed& point) {
      return std::pair(!point.is_whole, k + 1 < groups ? point.lean : -point.force_N);
    };
    out.push_back(std::ranges::min_element(at(k), at(k + 1), {}, rank)->point);
  }
  std::ranges::sort(out);
  return out;
}

std::vector<std::size_t> points_beyond_drags(const Samples& presses,
                                             const std::vector<std::size_t>& dragged) {
  const std::size_t most =
      std::min(static_cast<std::size_t>(presses.points()) / kPointsPerDrag, kLastDrags);
  std::vector<Pressed> points = deepest_rows(presses);
  // Rings of a drag are those of a flat surface up to a tenth of tangential over normal force.
  std::erase_if(points, [](const Pressed& point) { return !point.is_whole || point.lean > 0.1; });
  std::vector<double> known;
  for (const Pressed& point : points)
    if (std::ranges::find(dragged, point.point) != dragged.end())
      known.push_back(std::log(point.force_N));
  const auto away = [&](const Pressed& point) {
    double least = std::numeric_limits<double>::infinity();
    for (const double force : known)
      least = std::min(least, std::abs(std::log(point.force_N) - force));
    return least;
  };
  std::vector<std::size_t> out;
  while (!points.empty() && !known.empty() && out.size() < most) {
    const auto furthest = std::ranges::max_element(points, {}, away);
    // Forces further apart than this factor say nothing of each other's rings.
    if (!(away(*furthest) > std::log(1.1))) break;
    known.push_back(std::log(furthest->force_N));
    out.push_back(furthest->point);
  }
  return out;
}

}  // namespace palpate::tools
