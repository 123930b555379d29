#include "libfit/refine/match_triangles.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

namespace palpate {
namespace {

constexpr double kPositionTolerance = 1e-6;  // of the body: far above rounding, far below spacing

}  // namespace

Triangles match_triangles(const Points& position, const TestPoints& points, double size_m) {
  const Triangles none(0, 3);
  if (position.rows() != points.position.rows()) return none;
  const double tolerance_m = kPositionTolerance * size_m;
  std::vector<std::int32_t> by_x(static_cast<std::size_t>(position.rows()));
  std::iota(by_x.begin(), by_x.end(), 0);
  std::sort(by_x.begin(), by_x.end(),
            [&](auto a, auto b) { return position(a, 0) < position(b, 0); });
  std::vector<std::int32_t> row_of(by_x.size());
  std::vector<char> is_taken(by_x.size(), 0);
  for (Eigen::Index i = 0; i < points.position.rows(); ++i) {
    const auto wanted = points.position.row(i);
    auto at = std::lower_bound(by_x.begin(), by_x.end(), wanted[0] - tolerance_m,
                               [&](auto row, double x) { return position(row, 0) < x; });
    while (at != by_x.end() && position(*at, 0) <= wanted[0] + tolerance_m &&
           (is_taken[static_cast<std::size_t>(*at)] != 0 ||
            (position.row(*at) - wanted).norm() > tolerance_m))
      ++at;
    if (at == by_x.end() || position(*at, 0) > wanted[0] + tolerance_m) return none;
    is_taken[static_cast<std::size_t>(*at)] = 1;
    row_of[static_cast<std::size_t>(i)] = *at;
  }
  return points.triangles.unaryExpr(
      [&](std::int32_t point) { return row_of[static_cast<std::size_t>(point)]; });
}

}  // namespace palpate
