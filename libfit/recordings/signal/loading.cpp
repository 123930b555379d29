#include <algorithm>
#include <cmath>
#include <limits>

#include "libfit/core/statistics.hpp"
#include "libfit/recordings/signal/signal.hpp"

namespace palpate::recordings {
namespace {

constexpr double kDeeper = 0.05;       // of the travel's range: a cycle that goes on
constexpr double kPressed = 0.1;       // of the largest push: below it a way in touches nothing
constexpr double kDropShare = 0.2;     // of the push so far
constexpr double kDropInNoise = 8;     // deviations
constexpr double kWaveShare = 0.05;    // of the rows that press, on either side of a mean
constexpr double kPeakInNoise = 10;    // deviations: below it nothing breaks
constexpr double kDropTravel = 0.05;   // of the way in since push began to rise, within which
constexpr Eigen::Index kDropRows = 6;  // or within so many rows, where they are far apart
constexpr double kBreakShare = 0.2;    // of the largest push
constexpr double kGoesOn = 0.3;        // of the mean stride
constexpr double kBeyond = 0.1;        // of the way in
constexpr Eigen::Index kFewestBefore = 8;

// Deviation of push from the mean of its neighbours where it is above least_N: a sensor's
// light, a motor or a body that is rough, none of which breaks. By the median, which one break
// leaves.
double waves_N(const Eigen::VectorXd& push, double least_N) {
  const auto pressed = static_cast<double>((push.array() > least_N).count());
  const auto reach = std::max<Eigen::Index>(2, static_cast<Eigen::Index>(kWaveShare * pressed));
  const Eigen::Index window = 2 * reach + 1;
  std::vector<double> off_N;
  double sum_N = push.head(std::min(window, push.size())).sum();
  for (Eigen::Index i = reach; i + reach < push.size(); ++i) {
    if (i > reach) sum_N += push[i + reach] - push[i - reach - 1];
    if (push[i] > least_N) off_N.push_back(std::abs(push[i] - sum_N / static_cast<double>(window)));
  }
  return off_N.empty() ? 0 : median(std::move(off_N)) / kMedianOfNormal;
}

}  // namespace

std::vector<RowRange> first_loadings(const Signal& signal) {
  const Eigen::VectorXd travel = signal.travel_m(), push = signal.push_N();
  const double range_m = travel.maxCoeff() - travel.minCoeff(), free_N = push[0],
               most_N = push.maxCoeff() - free_N;
  std::vector<RowRange> parts;
  double deepest_m = -std::numeric_limits<double>::infinity();
  for (const RowRange& rising : approaches(signal)) {
    RowRange part = rising;
    while (part.begin < part.end && travel[part.begin] <= deepest_m) ++part.begin;
    if (part.rows() < 2 || (!parts.empty() && travel[part.end - 1] < deepest_m + kDeeper * range_m))
      continue;
    if (push.segment(part.begin, part.rows()).maxCoeff() - free_N < kPressed * most_N) continue;
    deepest_m = travel[part.end - 1];
    parts.push_back(part);
  }
  if (parts.size() < 2) parts.clear();
  return parts;
}

std::optional<Eigen::Index> break_in_row(const Signal& signal, const RowRange& range) {
  const Eigen::VectorXd travel = signal.travel_m().segment(range.begin, range.rows()),
                        push = signal.push_N().segment(range.begin, range.rows());
  const Eigen::Index rows = range.rows();
  if (rows < 2 * kFewestBefore) return std::nullopt;
  const double free_N = push.head(kFewestBefore).mean(), way_m = travel[rows - 1] - travel[0],
               stride_m = way_m / static_cast<double>(rows - 1),
               noise_N =
                   std::max(neighbour_scatter(push),
                            std::sqrt((push.head(kFewestBefore).array() - free_N).square().mean())),
               least_N = std::max(kBreakShare * (push.maxCoeff() - free_N), kPeakInNoise * noise_N),
               pressed_N = free_N + kPressed * (push.maxCoeff() - free_N),
               seen_N = kDropInNoise * std::max(noise_N, waves_N(push, pressed_N));
  Eigen::Index top = 0;
  for (Eigen::Index i = kFewestBefore; i + 1 < rows; ++i) {
    if (push[i] > push[top] || top == 0) top = i;
    const double gone_m = travel[i] - travel[top];
    const bool is_near = gone_m <= kDropTravel * way_m || i - top <= kDropRows;
    // Push that falls while the tool holds relaxes; one that ends the way in springs back.
    if (gone_m < kGoesOn * stride_m * static_cast<double>(i - top) ||
        travel[rows - 1] < travel[top] + kBeyond * way_m || push[top] - free_N < least_N)
      continue;
    const double drop_N = push[top] - push[i];
    const auto at = [&](Eigen::Index k) { return static_cast<std::size_t>(range.begin + k); };
    if (!is_near || i == top || signal.is_saturated[at(top)] || signal.is_spike[at(i)]) continue;
    // The next reading says that it is no single one, and the tool goes on inward.
    if (drop_N > kDropShare * (push[top] - free_N) && drop_N > seen_N &&
        push[top] - push[i + 1] > kDropShare * (push[top] - free_N) && travel[i + 1] >= travel[top])
      return range.begin + top;
  }
  return std::nullopt;
}

}  // namespace palpate::recordings
