#pragma once

#include <vector>

#include "libfit/recordings/signal/signal.hpp"

namespace palpate::recordings {

/// What the tip does in a row.
enum class Phase : char { approach, hold, retract, slide };

/// Rows [begin, end).
struct RowRange {
  Eigen::Index begin = 0, end = 0;
  Eigen::Index rows() const { return end - begin; }
};

/// What the tip does, row by row: it changes direction where the travel turns back by more than 2 %
/// of its whole range; it slides where it goes farther sideways than inward, and holds where over a
/// 2 % window of the rows it goes neither way by more than a tenth of the mean speed. Where the
/// file says that the way back begins, that is believed.
std::vector<Phase> find_phases(const Signal& signal);

/// The way in, from its lowest to its highest travel: the approach that gains most travel. Empty
/// when there is none.
RowRange main_approach(const Signal& signal, const std::vector<Phase>& phases);

/// The other approaches and the ways back that go at least 90 % as far as `approach` does, from
/// where it begins to where it ends: cycles of one recording.
std::vector<RowRange> cycles_like(const Signal& signal, const std::vector<Phase>& phases,
                                  const RowRange& approach);

/// The way back after it, to where the next approach begins; empty when there is none.
RowRange retract_after(const Signal& signal, const std::vector<Phase>& phases,
                       const RowRange& approach);

}  // namespace palpate::recordings
