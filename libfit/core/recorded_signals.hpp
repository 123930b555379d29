#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace palpate {

inline constexpr std::array<std::string_view, 5> kPhaseNames{"approach", "hold", "retract", "slide",
                                                             "unknown"};
inline constexpr std::array<std::string_view, 4> kRecordingGradeNames{"good", "fair", "poor",
                                                                      "refused"};
inline constexpr std::int8_t kRefusedGrade = 3;

/// Readings of one recording that a picture of it is drawn from, in the order recorded; without any
/// where the file gave no signal. N readings.
struct SignalTrace {
  std::vector<float> time_s;         ///< N since the first reading; NaN without a clock
  std::vector<float> travel_m;       ///< N along the inward direction, in the recording's own zero
  std::vector<float> push_N;         ///< N of the tip ON the body along it, as recorded
  std::vector<std::int8_t> phase;    ///< N, of kPhaseNames
  std::vector<char> is_used;         ///< N: 1 where samples come from
  double bias_N = 0, drift_N_m = 0;  ///< what was taken off the push: bias_N + drift_N_m travel

  std::size_t readings() const { return push_N.size(); }
};

/// One recording of an import as it came, imported or refused: a row of samples.signals.h5
/// (docs/formats.md). Numbers are NaN where there are none.
struct RecordedSignal {
  std::string file;              ///< as the manifest names it, with `#name` within a file
  std::string point;             ///< of the samples
  std::int32_t experiment = -1;  ///< of the samples; -1 of refused ones
  std::int8_t grade = 0;         ///< of kRecordingGradeNames
  std::string reasons;           ///< of the grade; why it was refused, and the remedy
  std::string estimator;         ///< of the contact point; empty where there is none
  double contact_m = std::numeric_limits<double>::quiet_NaN();  ///< travel at first touch
  double contact_deviation_m = std::numeric_limits<double>::quiet_NaN();
  double noise_N = std::numeric_limits<double>::quiet_NaN();  ///< of one reading without contact
  SignalTrace trace;
};

}  // namespace palpate
