#pragma once

#include "libfit/recordings/relaxation/press_group.hpp"

namespace palpate::recordings {

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
Alignment align_contacts(const std::vector<RelaxingPress>& presses, const Relaxation& relaxation,
                         SlowCurve curve);

}  // namespace palpate::recordings
