#include <cmath>
#include <limits>
#include <set>

#include "libfit/recordings/signal/signal.hpp"

namespace palpate::recordings {
namespace {

constexpr Eigen::Index kReadings = 200;  // of a picture 400 points wide

// About `count` of the rows [begin, end), equally spaced, the last among them.
void spread(Eigen::Index begin, Eigen::Index end, Eigen::Index count,
            std::set<Eigen::Index>& rows) {
  const Eigen::Index last = end - 1 - begin, steps = std::min(count - 1, last);
  for (Eigen::Index k = 0; k <= steps; ++k)
    rows.insert(begin + (steps > 0 ? last * k / steps : last));
}

std::set<Eigen::Index> rows_shown(const Signal& signal) {
  std::set<Eigen::Index> rows;
  const auto& [travel_m, push_N] = signal.recorded;
  const Eigen::Index n = push_N.size(), most = kReadings - 2;
  const RowRange& in = signal.range.loading;
  const bool has_press = signal.bias_N.size() > 0 && in.rows() > 1 && n > most;
  spread(0, n, has_press ? most / 2 : most, rows);
  if (has_press) {
    const double deepest_m = travel_m[in.end - 1],
                 from_m = signal.contact_m - (deepest_m - signal.contact_m);
    Eigen::Index begin = in.end - 1;
    while (begin > in.begin && travel_m[begin - 1] >= from_m) --begin;
    spread(begin, in.end, most / 2, rows);
  }
  Eigen::Index row = 0;
  for (const Eigen::VectorXd* column : {&push_N, &travel_m}) {
    column->maxCoeff(&row);
    rows.insert(row);
  }
  return rows;
}

bool is_in(const std::vector<RowRange>& ranges, Eigen::Index row) {
  for (const RowRange& range : ranges)
    if (row >= range.begin && row < range.end) return true;
  return false;
}

}  // namespace

SignalTrace trace_of(const Signal& signal) {
  SignalTrace trace;
  const auto& [travel_m, push_N] = signal.recorded;
  if (push_N.size() == 0) return trace;
  for (const Eigen::Index row : rows_shown(signal)) {
    trace.time_s.push_back(signal.time_s.empty()
                               ? std::numeric_limits<float>::quiet_NaN()
                               : static_cast<float>(signal.time_s[row] - signal.time_s[0]));
    trace.travel_m.push_back(static_cast<float>(travel_m[row]));
    trace.push_N.push_back(static_cast<float>(push_N[row]));
    trace.phase.push_back(signal.phase.empty() ? std::int8_t{4}
                                               : static_cast<std::int8_t>(signal.phase[row]));
    trace.is_used.push_back(is_in(signal.range.used, row));
  }
  if (signal.bias_N.size() == 0) return trace;
  Eigen::Index low = 0, high = 0;  // a line over travel
  const double range_m = travel_m.maxCoeff(&high) - travel_m.minCoeff(&low);
  if (range_m > 0) trace.drift_N_m = (signal.bias_N[high] - signal.bias_N[low]) / range_m;
  trace.bias_N = signal.bias_N[low] - trace.drift_N_m * travel_m[low];
  return trace;
}

}  // namespace palpate::recordings
