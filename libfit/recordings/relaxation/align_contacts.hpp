#pragma once

#include "libfit/recordings/relaxation/press_group.hpp"

namespace palpate::recordings {

/// How far beyond where it was found the contact of a recording lies, and its deviation then.
struct ContactShift {
  double moved_m = 0, deviation_m = 0;
};

/// Contacts of recordings of one point by which they have one curve of slow motion, for a series
/// that is known (M51a). One for each recording.
std::vector<ContactShift> align_contacts(const std::vector<RelaxingPress>& presses,
                                         const Relaxation& relaxation, SlowCurve curve);

}  // namespace palpate::recordings
