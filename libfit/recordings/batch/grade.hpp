#pragma once

#include "libfit/recordings/batch/condition.hpp"
#include "libfit/recordings/contact_point/contact_point.hpp"

namespace palpate::recordings {

/// Lowers the grade of a recording to what its rows, noise (neighbours correlate by `correlation`)
/// and contact point allow, with a reason each, and fills in the apparent modulus.
void grade(const SignalSettings& settings, const ContactEstimate& contact, double correlation,
           Conditioned& out);

}  // namespace palpate::recordings
