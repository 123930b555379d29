#pragma once

#include "libfit/recordings/relaxation/series_search.hpp"

namespace palpate::recordings {

/// Covariance of the values that a search found (M52): logarithms of shares, then of times, then
/// the shifts of each group. 0 of a time at an end of what is sought, and of a series that is
/// known.
Eigen::MatrixXd series_covariance(const SeriesSearch& with, const SeriesValues& values,
                                  bool is_series_known = false);

/// Covariance of the residuals of n rows in time (M52a): noise of the rows' own and drift of the
/// sensor, whose power goes as 1/f, in the proportion and of the size that restricted likelihood
/// gives, mean over proportions. noise: n, deviations by readings alone, in any unit. weight: n,
/// residual per newton. residual: n, what a linear fit by the columns of `slopes` (n x p) left.
/// Source: Patterson and Thompson, Biometrika 58 (1971).
Eigen::MatrixXd sensor_covariance(const Eigen::VectorXd& time_s, const Eigen::VectorXd& noise,
                                  const Eigen::VectorXd& weight, const Eigen::VectorXd& residual,
                                  const Eigen::MatrixXd& slopes);

}  // namespace palpate::recordings
