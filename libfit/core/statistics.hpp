#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

namespace palpate {

/// The value of a rank, counted from 0 in rising order; 0 without values.
inline double value_of_rank(std::vector<double> values, std::size_t rank) {
  if (values.empty()) return 0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(std::min(rank, values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Nearest-rank quantile, the least value that a share of them does not exceed; 0 without values.
/// Every figure that is reported is one of these. share: 0 to 1.
/// Source: Hyndman and Fan, Sample quantiles in statistical packages (1996), definition 1.
inline double quantile(std::vector<double> values, double share) {
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
  return value_of_rank(std::move(values), std::max<std::size_t>(rank, 1) - 1);
}

/// The value of rank floor(share (n - 1)), at most one rank below `quantile`: of few values the
/// largest counts only for share = 1. What the fit scales and decides by; 0 without values.
inline double lower_quantile(std::vector<double> values, double share) {
  const double last = values.empty() ? 0 : static_cast<double>(values.size() - 1);
  return value_of_rank(std::move(values), static_cast<std::size_t>(share * last));
}

/// The middle value, of an even number the lower of the two; 0 without values.
inline double median(std::vector<double> values) { return lower_quantile(std::move(values), 0.5); }

/// The least value up to which at least half of all weight lies; 0 without values. weights: of each
/// value, not negative. Of equal weights it is `median`.
inline double weighted_median(const std::vector<double>& values,
                              const std::vector<double>& weights) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  const double half = std::accumulate(weights.begin(), weights.end(), 0.0) / 2;
  double so_far = 0;
  for (const std::size_t i : order) {
    so_far += weights[i];
    // A hair below the half, so that rounding does not take the upper one of an even number.
    if (so_far >= half * (1 - 1e-12)) return values[i];
  }
  return 0;
}

/// The middle value, of an even number the upper of the two; 0 without values. Of a signal whose
/// readings repeat it is the last to be 0.
inline double upper_median(std::vector<double> values) {
  const std::size_t middle = values.size() / 2;
  return value_of_rank(std::move(values), middle);
}

}  // namespace palpate
