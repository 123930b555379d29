#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libfit/recordings/formats/recording.hpp"
#include "libfit/recordings/signal/settings.hpp"

namespace palpate::recordings {

/// The presses of a recording with three axes, a recording for each place in the order pressed, "1"
/// to "9" in the recording's name: where the tool lifts off, goes sideways by more than either
/// press is deep, and presses again. The recording as it is where there is one place, and where
/// `condition` is going to refuse it. inward: unit, where the manifest says it.
std::vector<importers::RawRecording> split_places(const importers::RawRecording& raw,
                                                  const SignalSettings& settings,
                                                  const std::optional<Vec3>& inward,
                                                  bool drop_invalid);

}  // namespace palpate::recordings
