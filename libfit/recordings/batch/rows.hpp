#pragma once

#include "libfit/recordings/batch/condition.hpp"
#include "libfit/recordings/signal/phases.hpp"

namespace palpate::recordings {

/// Fills the rows of `out` from the signal's rows `used`, those of `more` with them: means over
/// equal steps of depth for a press, of the tip's path since contact for a drag or path. Errors are
/// the noise over the square root of the readings that count (neighbours with `correlation` r count
/// (1 - r) / (1 + r)).
void take_rows(const Signal& signal, const RowRange& used, const std::vector<RowRange>& more,
               double contact_travel_m, const SignalSettings& settings, double correlation,
               Conditioned& out);

/// First row of the way back after the sliding of a drag.
Eigen::Index end_of_drag(const Signal& signal, const std::vector<Phase>& phases,
                         const RowRange& approach);

/// Share of the depth (or path) that lies beyond the first saturated row.
double saturated_share(const Conditioned& recording);

}  // namespace palpate::recordings
