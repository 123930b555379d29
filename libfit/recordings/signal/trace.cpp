#include "libfit/recordings/signal/trace.hpp"

#include <cmath>
#include <limits>
#include <set>

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

std::set<Eigen::Index> rows_shown(const SeenSignal& seen) {
  std::set<Eigen::Index> rows;
  const Eigen::Index n = seen.push_N.size(), most = kReadings - 2;
  const RowRange& in = seen.approach;
  const bool has_press = in.rows() > 1 && n > most;
  spread(0, n, has_press ? most / 2 : most, rows);
  if (has_press) {
    const double deepest_m = seen.travel_m[in.end - 1],
                 from_m = seen.contact_m - (deepest_m - seen.contact_m);
    Eigen::Index begin = in.end - 1;
    while (begin > in.begin && seen.travel_m[begin - 1] >= from_m) --begin;
    spread(begin, in.end, most / 2, rows);
  }
  Eigen::Index row = 0;
  for (const Eigen::VectorXd* signal : {&seen.push_N, &seen.travel_m}) {
    signal->maxCoeff(&row);
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

SignalTrace trace_of(const SeenSignal& seen) {
  SignalTrace trace;
  if (seen.push_N.size() == 0) return trace;
  for (const Eigen::Index row : rows_shown(seen)) {
    const auto i = static_cast<std::size_t>(row);
    trace.time_s.push_back(seen.time_s.empty()
                               ? std::numeric_limits<float>::quiet_NaN()
                               : static_cast<float>(seen.time_s[i] - seen.time_s[0]));
    trace.travel_m.push_back(static_cast<float>(seen.travel_m[row]));
    trace.push_N.push_back(static_cast<float>(seen.push_N[row]));
    trace.phase.push_back(seen.phase.empty() ? std::int8_t{4}
                                             : static_cast<std::int8_t>(seen.phase[i]));
    trace.is_used.push_back(is_in(seen.used, row));
  }
  if (seen.bias_N.size() == 0) return trace;
  Eigen::Index low = 0, high = 0;  // a line over travel
  const double range_m = seen.travel_m.maxCoeff(&high) - seen.travel_m.minCoeff(&low);
  if (range_m > 0) trace.drift_N_m = (seen.bias_N[high] - seen.bias_N[low]) / range_m;
  trace.bias_N = seen.bias_N[low] - trace.drift_N_m * seen.travel_m[low];
  return trace;
}

}  // namespace palpate::recordings
