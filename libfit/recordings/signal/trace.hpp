#pragma once

#include "libfit/core/recorded_signals.hpp"
#include "libfit/recordings/signal/signal.hpp"

namespace palpate::recordings {

/// What is seen of a signal on the way to samples, N rows; what is not known yet is empty.
struct SeenSignal {
  std::vector<double> time_s;        ///< N, or empty without a clock
  Eigen::VectorXd travel_m, push_N;  ///< N, as recorded
  std::vector<Phase> phase;          ///< N, or empty
  std::vector<RowRange> used;        ///< rows that samples come from
  Eigen::VectorXd bias_N;            ///< N, what was taken off the push, or empty

  /// Where the press is: its way in and its contact point.
  RowRange approach;
  double contact_m = 0;
};

/// At most 200 rows of it: half of them equally spaced over all, half over the way in from as far
/// before the contact point as the press goes beyond it; and the rows of largest push and travel.
SignalTrace trace_of(const SeenSignal& seen);

}  // namespace palpate::recordings
