#pragma once

#include <string>

#include "libfit/recordings/batch/condition.hpp"
#include "libfit/recordings/batch/ways_in.hpp"
#include "libfit/recordings/contact_point/contact_point.hpp"
#include "libfit/recordings/signal/signal.hpp"
#include "libfit/recordings/signal/trace.hpp"

namespace palpate::recordings {

/// A contact point, and what was seen of the noise before it.
struct TouchedSignal {
  ContactEstimate contact;
  double correlation = 0;  ///< of neighbours in the noise; 0 where nothing is free
};

/// The contact point as the settings ask for it, given or estimated, with the mean (or line) of
/// the free push taken off all rows and axes of `signal`. Fills in contact, noise and speed of
/// `out`, and what a picture shows of `seen`. Throws Error
/// (file:line, what, remedy) where the way in holds no contact or has the other sign.
TouchedSignal find_contact(const importers::RawRecording& raw, const SignalSettings& settings,
                           const std::string& file, const WaysIn& ways, Signal& signal,
                           SeenSignal& seen, Conditioned& out);

}  // namespace palpate::recordings
