#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libfit/recordings/batch/condition.hpp"
#include "libfit/recordings/signal/signal.hpp"
#include "libfit/recordings/signal/trace.hpp"

namespace palpate::recordings {

/// Where the tip goes into the body.
struct WaysIn {
  std::vector<RowRange> loadings;  ///< of a press in cycles that go deeper and deeper; else none
  std::vector<RowRange> cycles;    ///< other ways whose rows count with those of `range`
  RowRange range, whole;           ///< the part that loads, and all of it
  std::optional<Eigen::Index> broken;  ///< last row before the tool breaks in
};

/// The way in that the settings ask for, up to where the tool breaks in. Says in `recording` that
/// there are others as deep, and how they differ. Throws Error (file:line, what, remedy) where the
/// tip never goes in, or not as often as `cycle` asks for.
WaysIn ways_in(const Signal& signal, const std::vector<Phase>& phases,
               const SignalSettings& settings, const std::string& file, Conditioned& recording);

/// Rows that samples come from. back: the way out after the press.
RowRange used_rows(const Signal& signal, const std::vector<Phase>& phases,
                   const SignalSettings& settings, const WaysIn& ways, const RowRange& back);

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
