#include "libfit/refine/next_points.hpp"

#include <algorithm>
#include <cmath>

namespace palpate {

std::vector<std::int32_t> next_points(const Surface& fine, const std::vector<char>& is_candidate,
                                      const std::vector<EdgePathSeeds>& points,
                                      std::vector<double> expected_error,
                                      const NextPointsOptions& options) {
  std::vector<double> distance_m = nearest_source(fine, points).distance_m;
  const auto is_free = [&](std::size_t v) {
    return is_candidate[v] && distance_m[v] > 0 && std::isfinite(distance_m[v]);
  };
  double largest_m = 0;
  for (std::size_t v = 0; v < distance_m.size(); ++v)
    if (is_free(v)) largest_m = std::max(largest_m, distance_m[v]);
  for (std::size_t v = 0; v < distance_m.size(); ++v)
    if (is_free(v)) {
      const double share = distance_m[v] / largest_m;
      expected_error[v] += options.gap_error * share * share;
    }

  const int gaps = static_cast<int>(std::lround(options.gap_share * options.count));
  std::vector<std::int32_t> picked;
  while (static_cast<int>(picked.size()) < options.count) {
    const bool fills_gap = static_cast<int>(picked.size()) >= options.count - gaps;
    const std::vector<double>& score = fills_gap ? distance_m : expected_error;
    std::int32_t best = -1;
    for (std::size_t v = 0; v < score.size(); ++v)
      if (is_free(v) && (best < 0 || score[v] > score[static_cast<std::size_t>(best)]))
        best = static_cast<std::int32_t>(v);
    if (best < 0) break;
    picked.push_back(best);
    const auto from_pick = nearest_source(fine, {{{best, 0.0}}}).distance_m;
    for (std::size_t v = 0; v < distance_m.size(); ++v) {
      if (!(from_pick[v] < distance_m[v])) continue;
      const double share = from_pick[v] / distance_m[v];
      expected_error[v] *= share * share;
      distance_m[v] = from_pick[v];
    }
  }
  return picked;
}

}  // namespace palpate
