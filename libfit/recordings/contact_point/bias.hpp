#pragma once

#include "libfit/recordings/batch/condition.hpp"
#include "libfit/recordings/contact_point/approach.hpp"

namespace palpate::recordings {

/// Takes the free push (its mean, or its line over travel) off all rows and axes, and says in `out`
/// how noisy it is. Returns the correlation of neighbours in that noise; 0 where nothing is free.
double take_off_bias(Signal& signal, const Approach& way, const ContactEstimate& contact,
                     const SignalSettings& settings, Conditioned& out);

}  // namespace palpate::recordings
