#pragma once

#include "libfit/recordings/relaxation/series_search.hpp"

namespace palpate::recordings {

/// Covariance of the values that a search found (M52): logarithms of shares, then of times, then
/// the shifts of each group. 0 of a time at an end of what is sought, and of a series that is
/// known.
Eigen::MatrixXd series_covariance(const SeriesSearch& with, const SeriesValues& values,
                                  bool is_series_known = false);

}  // namespace palpate::recordings
