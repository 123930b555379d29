#pragma once

#include <string>
#include <vector>

#include "libfit/recordings/batch/condition.hpp"

// Steps of `condition`, for this folder alone, in their order.

namespace palpate::recordings {

/// Finds approach, loading, first loadings and break of the press that the settings ask for. Notes
/// in `out` that there are others as deep, and how they differ. Throws Error (file:line, what,
/// remedy) where the tip never goes in, or not as often as `cycle` asks for.
void find_ranges(const SignalSettings& settings, const std::string& file, Signal& signal,
                 Conditioned& out);

/// Finds the contact point as the settings ask for it, given or estimated from the loading and
/// `cycles`, takes the mean (or line) of the free push off all rows and axes of `signal`, and fills
/// in contact, noise and speed of `out`. Throws Error (file:line, what, remedy) where the loading
/// holds no contact or has the other sign.
ContactEstimate find_contact(const importers::RawRecording& raw, const SignalSettings& settings,
                             const std::string& file, const std::vector<RowRange>& cycles,
                             Signal& signal, Conditioned& out);

/// Fills the rows of `out` from the signal's used ranges: means over equal steps of depth for a
/// press, of the tip's path since contact for a drag or path. Errors are the noise over the square
/// root of the readings that count (neighbours with correlation r count (1 - r) / (1 + r)).
void take_rows(const Signal& signal, const SignalSettings& settings, Conditioned& out);

/// Means of a press in cycles over levels of depth, loading by unloading, into `out`.
void take_cycles(const Signal& signal, Conditioned& out);

}  // namespace palpate::recordings
