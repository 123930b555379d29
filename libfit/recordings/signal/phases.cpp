#include "libfit/recordings/signal/signal.hpp"

#include <algorithm>
#include <cmath>

#include "libfit/core/statistics.hpp"

namespace palpate::recordings {
namespace {

constexpr double kHoldShare = 0.1;  // of the mean speed
constexpr double kPressed = 0.1;    // of the largest push: below it an approach touches nothing
constexpr double kDropShare = 0.2;  // of the push so far, where a tool breaks in
constexpr Eigen::Index kFewestBefore = 8;

// Rows where the travel turns, by the usual zigzag rule; first and last row included.
std::vector<Eigen::Index> turning_rows(const Eigen::VectorXd& travel, double min_m) {
  std::vector<Eigen::Index> turns{0};
  Eigen::Index lowest = 0, highest = 0;
  int direction = 0;
  for (Eigen::Index i = 1; i < travel.size(); ++i) {
    if (travel[i] < travel[lowest]) lowest = i;
    if (travel[i] > travel[highest]) highest = i;
    if (direction >= 0 && travel[highest] - travel[i] > min_m) {
      if (direction > 0 || highest > 0) turns.push_back(highest);
      direction = -1;
      lowest = i;
    } else if (direction <= 0 && travel[i] - travel[lowest] > min_m) {
      if (direction < 0 || lowest > 0) turns.push_back(lowest);
      direction = 1;
      highest = i;
    }
  }
  if (direction > 0 && highest + 1 < travel.size() && highest != turns.back())
    turns.push_back(highest);
  turns.push_back(travel.size() - 1);
  return turns;
}

std::vector<RowRange> runs_of(const std::vector<Phase>& phases, Phase phase) {
  const Eigen::Index rows = phases.size();
  const auto belongs = [&](Eigen::Index i) {  // a hold on the way does not end it
    const Phase at = phases[i];
    return at == phase || at == Phase::hold;
  };
  std::vector<RowRange> runs;
  for (Eigen::Index first = 0, last = 0; first < rows; first = std::max(last, first + 1)) {
    for (last = first; last < rows && belongs(last); ++last) {
    }
    if (last - first >= 2) runs.push_back({first, last});
  }
  return runs;
}

// From its lowest row on to its highest.
RowRange rising_part(const Eigen::VectorXd& travel, const RowRange& run) {
  Eigen::Index low = 0, high = 0;
  const auto part = travel.segment(run.begin, run.rows());
  part.maxCoeff(&high);
  part.head(high + 1).minCoeff(&low);
  return {run.begin + low, run.begin + high + 1};
}

// True of a run that begins and ends as far as an approach does, but for a tenth of its travel.
bool goes_as_far(const Eigen::VectorXd& travel, const RowRange& run, const RowRange& approach) {
  const double low_m = travel[approach.begin], high_m = travel[approach.end - 1],
               slack_m = 0.1 * (high_m - low_m);
  const auto part = travel.segment(run.begin, run.rows());
  return part.minCoeff() <= low_m + slack_m && part.maxCoeff() >= high_m - slack_m;
}

// Place of the tip beside its approach, as means of neighbours, so that an encoder's noise is no
// motion.
class SidewaysMotion {
 public:
  // reach: rows on either side in a mean.
  SidewaysMotion(const Points& sideways, Eigen::Index reach) : mean_(sideways) {
    const Eigen::Index rows = sideways.rows();
    for (Eigen::Index i = 0; reach > 0 && i < rows; ++i) {
      const Eigen::Index first = std::max<Eigen::Index>(0, i - reach),
                         end = std::min(rows, i + reach + 1);
      mean_.row(i) = sideways.middleRows(first, end - first).colwise().mean();
    }
    if (rows < 3) return;
    const Points bend = sideways.topRows(rows - 2) - 2 * sideways.middleRows(1, rows - 2) +
                        sideways.bottomRows(rows - 2);
    const Eigen::VectorXd size = bend.rowwise().norm();
    // Second differences of white noise on two axes have six times its variance.
    const double noise_m = median({size.begin(), size.end()}) / std::sqrt(6 * 2 * std::log(2.));
    // Within 5 deviations of an axis lie all but 4 of a million windows of noise.
    unseen_m_ = 5 * noise_m * std::sqrt(2. / static_cast<double>(2 * reach + 1));
  }

  // Beyond the noise, from one row to another.
  double way_m(Eigen::Index from, Eigen::Index to) const {
    const double way_m = (mean_.row(to) - mean_.row(from)).norm();
    return way_m > unseen_m_ ? way_m : 0;
  }

 private:
  Points mean_;
  double unseen_m_ = 0;
};

// Deviation of push from the mean of its neighbours where it is above least_N: a sensor's
// light, a motor or a body that is rough, none of which breaks. By the median, which one break
// leaves.
double waves_N(const Eigen::VectorXd& push, double least_N) {
  const auto pressed = static_cast<double>((push.array() > least_N).count());
  const auto reach = std::max<Eigen::Index>(2, static_cast<Eigen::Index>(0.05 * pressed));
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

std::vector<Phase> find_phases(const Signal& signal) {
  const Eigen::VectorXd travel = signal.travel_m();
  const Eigen::Index rows = travel.size();
  std::vector<Phase> phases(rows, Phase::hold);
  const double range_m = travel.maxCoeff() - travel.minCoeff();
  const std::vector<Eigen::Index> turns = turning_rows(travel, 0.02 * range_m);
  for (std::size_t k = 0; k + 1 < turns.size(); ++k) {
    const double gain_m = travel[turns[k + 1]] - travel[turns[k]];
    std::fill(phases.begin() + turns[k], phases.begin() + turns[k + 1] + 1,
              gain_m > 0 ? Phase::approach : Phase::retract);
  }
  if (rows < 20) return phases;
  const auto half =
      std::max<Eigen::Index>(1, static_cast<Eigen::Index>(0.02 * static_cast<double>(rows) / 2));
  const SidewaysMotion sideways(signal.position_m - travel * signal.inward.transpose(), half / 2);
  double path_m = 0;
  for (Eigen::Index i = half; i < rows; i += half)
    path_m += std::hypot(travel[i] - travel[i - half], sideways.way_m(i - half, i));
  for (Eigen::Index i = 0; i < rows; ++i) {
    const Eigen::Index a = std::max<Eigen::Index>(0, i - half), b = std::min(rows - 1, i + half);
    const double in_m = std::abs(travel[b] - travel[a]), side_m = sideways.way_m(a, b);
    const double mean_m = path_m * static_cast<double>(b - a) / static_cast<double>(rows);
    if (side_m > in_m && side_m > kHoldShare * mean_m)
      phases[i] = Phase::slide;
    else if (in_m < kHoldShare * mean_m && side_m < kHoldShare * mean_m)
      phases[i] = Phase::hold;
  }
  return phases;
}

std::vector<RowRange> approaches(const Signal& signal) {
  const Eigen::VectorXd travel = signal.travel_m();
  std::vector<RowRange> out;
  for (const RowRange& run : runs_of(signal.phase, Phase::approach))
    out.push_back(rising_part(travel, run));
  return out;
}

RowRange main_approach(const Signal& signal) {
  const Eigen::VectorXd travel = signal.travel_m();
  const auto gain_m = [&](const RowRange& in) { return travel[in.end - 1] - travel[in.begin]; };
  const std::vector<RowRange> all = approaches(signal);
  const auto best = std::ranges::max_element(all, {}, gain_m);
  return best != all.end() && gain_m(*best) > 0 ? *best : RowRange{};
}

std::vector<RowRange> cycles_like(const Signal& signal, const RowRange& approach) {
  const Eigen::VectorXd travel = signal.travel_m();
  std::vector<RowRange> cycles;
  for (const Phase phase : {Phase::approach, Phase::retract})
    for (const RowRange& run : runs_of(signal.phase, phase)) {
      const bool is_itself =
          phase == Phase::approach && run.begin <= approach.begin && approach.end <= run.end;
      if (!is_itself && goes_as_far(travel, run, approach))
        cycles.push_back(phase == Phase::approach ? rising_part(travel, run) : run);
    }
  return cycles;
}

std::vector<RowRange> presses_like(const Signal& signal, const RowRange& approach) {
  std::vector<RowRange> presses = approaches(signal);
  std::erase_if(presses, [&, travel = signal.travel_m()](const RowRange& press) {
    return !goes_as_far(travel, press, approach);
  });
  return presses;
}

RowRange retract_after(const Signal& signal, const RowRange& approach) {
  const std::vector<Phase>& phases = signal.phase;
  const Eigen::Index rows = phases.size();
  Eigen::Index begin = approach.end;
  while (begin < rows && phases[begin] != Phase::retract) {
    if (phases[begin] == Phase::approach && begin > approach.end + 2) return {};
    ++begin;
  }
  Eigen::Index end = begin;
  while (end < rows && phases[end] != Phase::approach) ++end;
  return {begin, end};
}

std::optional<Eigen::Index> break_in_row(const Signal& signal, const RowRange& range) {
  const Eigen::VectorXd travel = signal.travel_m().segment(range.begin, range.rows()),
                        push = signal.push_N().segment(range.begin, range.rows());
  const Eigen::Index rows = range.rows();
  if (rows < 2 * kFewestBefore) return std::nullopt;
  const double free_N = push.head(kFewestBefore).mean(), gain_m = travel[rows - 1] - travel[0],
               stride_m = gain_m / static_cast<double>(rows - 1),
               noise_N =
                   std::max(neighbour_scatter(push),
                            std::sqrt((push.head(kFewestBefore).array() - free_N).square().mean())),
               least_N = std::max(0.2 * (push.maxCoeff() - free_N), 10 * noise_N),
               pressed_N = free_N + kPressed * (push.maxCoeff() - free_N),
               seen_N = 8 * std::max(noise_N, waves_N(push, pressed_N));
  Eigen::Index top = 0;
  for (Eigen::Index i = kFewestBefore; i + 1 < rows; ++i) {
    if (push[i] > push[top] || top == 0) top = i;
    const double gone_m = travel[i] - travel[top];
    const bool is_near = gone_m <= 0.05 * gain_m || i - top <= 6;  // rows may be far apart
    // Push that falls while the tool holds relaxes; one that ends the approach springs back.
    if (gone_m < 0.3 * stride_m * static_cast<double>(i - top) ||
        travel[rows - 1] < travel[top] + 0.1 * gain_m || push[top] - free_N < least_N)
      continue;
    const double drop_N = push[top] - push[i];
    if (!is_near || i == top || signal.is_saturated[range.begin + top] ||
        signal.is_spike[range.begin + i])
      continue;
    // The next reading says that it is no single one, and the tool goes on inward.
    if (drop_N > kDropShare * (push[top] - free_N) && drop_N > seen_N &&
        push[top] - push[i + 1] > kDropShare * (push[top] - free_N) && travel[i + 1] >= travel[top])
      return range.begin + top;
  }
  return std::nullopt;
}

}  // namespace palpate::recordings
