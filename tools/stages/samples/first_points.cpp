#include "tools/stages/samples/first_points.hpp"

#include <algorithm>
#include <limits>

namespace palpate::tools {
namespace {

struct Pressed {
  std::size_t point = 0;
  double force_N = 0;
  double lean = 0;  // of the deepest row: tangential over normal force
  bool is_whole = true;
};

std::vector<Pressed> deepest_rows(const Samples& presses) {
  std::vector<Pressed> out(static_cast<std::size_t>(presses.points()));
  for (std::size_t p = 0; p < out.size(); ++p) out[p].point = p;
  for (Eigen::Index row = 0; row < presses.rows(); ++row) {
    const auto r = static_cast<std::size_t>(row);
    Pressed& point = out[static_cast<std::size_t>(presses.point[r])];
    if (presses.status[r] != RowStatus::good) point.is_whole = false;
    const Vec3 force = presses.force.row(row), normal = presses.point_normal.row(presses.point[r]);
    if (!(force.norm() > point.force_N)) continue;
    point.force_N = force.norm();
    const double pressed_N = force.dot(normal);
    point.lean = pressed_N > 0 ? (force - pressed_N * normal).norm() / pressed_N
                               : std::numeric_limits<double>::infinity();
  }
  std::erase_if(out, [](const Pressed& point) { return !(point.force_N > 0); });
  return out;
}

// `count` of the points, evenly from the least to the greatest force.
std::vector<std::size_t> spread_by_force(std::vector<Pressed> points, std::size_t count) {
  std::ranges::stable_sort(points, {}, &Pressed::force_N);
  count = std::min(count, points.size());
  std::vector<std::size_t> out;
  for (std::size_t k = 0; k < count; ++k)
    out.push_back(points[count > 1 ? (points.size() - 1) * k / (count - 1) : 0].point);
  return out;
}

}  // namespace

FirstPoints choose_first_points(const Samples& presses) {
  std::vector<Pressed> points = deepest_rows(presses);
  std::ranges::stable_sort(points, {}, [](const Pressed& point) {
    return point.is_whole ? point.lean : std::numeric_limits<double>::infinity();
  });
  const auto clean = static_cast<std::ptrdiff_t>(
      std::min(points.size(), std::max(kFirstDrags, points.size() / 2)));
  FirstPoints out;
  out.dragged = spread_by_force({points.begin(), points.begin() + clean}, kFirstDrags);
  out.on_two_meshes = spread_by_force({points.begin() + clean, points.end()}, kFirstCompared);
  out.on_two_meshes.insert(out.on_two_meshes.end(), out.dragged.begin(), out.dragged.end());
  std::ranges::sort(out.dragged);
  std::ranges::sort(out.on_two_meshes);
  return out;
}

}  // namespace palpate::tools
