#pragma once

#include <vector>

#include "libfit/core/body.hpp"
#include "libfit/recordings/relaxation/series_search.hpp"

namespace palpate::recordings {

/// A Prony series that recordings in time support, with 95 % intervals.
struct RelaxationFit {
  Relaxation relaxation;       ///< no branches: nothing is gained by one
  Eigen::MatrixXd covariance;  ///< 2K x 2K, of ln share and ln time, shares first (M52)
  Eigen::VectorXd share_low, share_high, time_low_s, time_high_s;  ///< K
  std::vector<char> is_slower;           ///< K: its time is at the end of what the recordings tell
  std::vector<char> is_faster;           ///< K: likewise at the beginning
  double shortest_s = 0, longest_s = 0;  ///< times that the recordings tell
  SlowCurve curve = SlowCurve::powers;
  /// Error of stretches of time that a fit did not see, over the deviation of a row, root mean
  /// square: by number of branches, as far as they were tried.
  std::vector<double> held_out;
  double rms_N = 0;                       ///< of what is left of all rows
  std::vector<Eigen::VectorXd> fitted_N;  ///< of each recording's rows, point by point

  /// Largest and least stiffening within the 95 % band at times since a step (M53).
  struct Band {
    Eigen::VectorXd low, middle, high;
  };
  Band band(const Eigen::VectorXd& time_s) const;
};

/// Identifies relaxation from recordings of points, a vector of recordings each. Nothing where no
/// recording has rows. Does not depend on threads. exactly: so many branches, without a choice; -1:
/// held-out stretches choose.
RelaxationFit fit_relaxation(const std::vector<std::vector<TimedPress>>& points, int exactly = -1);

/// How far beyond where it was found the contact of a recording lies, and its deviation then.
struct ContactShift {
  double moved_m = 0, deviation_m = 0;
  double shift_deviation_m = 0;  ///< its part against the other recordings
};

/// Recordings of one point as they have one curve of slow motion.
struct Alignment {
  std::vector<ContactShift> contact;  ///< of each recording
  /// Rows of each recording: what a tool in slow motion would have read there, noise and all.
  std::vector<Eigen::VectorXd> slow_push_N;
};

/// Aligns the contacts of recordings of one point, for a series that is known (M51a).
Alignment align_contacts(const std::vector<TimedPress>& presses, const Relaxation& relaxation,
                         SlowCurve curve);

}  // namespace palpate::recordings
