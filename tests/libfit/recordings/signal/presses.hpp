#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <string>

#include "libfit/core/error.hpp"
#include "libfit/recordings/batch/batch.hpp"

// Presses with a closed form, as signals of a rig.
namespace palpate::recordings::testing_signal {

inline constexpr unsigned kPressSeed = 7;

/// A tip that goes in at 2 mm/s after 1 mm of air; its force is as the depth^1.5.
inline importers::RawRecording axial_press(int rows, double rate_hz) {
  importers::RawRecording raw;
  for (int i = 0; i < rows; ++i) {
    const double t = i / rate_hz, travel = 2e-3 * t, depth = std::max(0.0, travel - 1e-3);
    raw.time_s.push_back(t);
    raw.travel_m.push_back(travel);
    raw.line.push_back(static_cast<std::size_t>(i) + 2);
    raw.push_N.push_back(0.05 + 3e4 * std::pow(depth, 1.5) + 1e-4 * std::sin(40.0 * i));
  }
  return raw;
}

/// A ball of 5 mm pressed 3 mm into 10 kPa after 1 mm of air and back, at a constant speed, turning
/// at a reading or between two; exactly elastic but for the noise.
inline importers::RawRecording elastic_press(int readings, double turn, double noise_N,
                                             unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, noise_N);
  importers::RawRecording raw;
  for (int i = 0; i < readings; ++i) {
    const double way = (i + turn) / (readings - 1), share = way < 0.5 ? 2 * way : 2 - 2 * way;
    raw.time_s.push_back(0.02 * i);
    raw.travel_m.push_back(4e-3 * share);
    raw.push_N.push_back(4.0 / 3 * 1e4 / 0.75 * std::sqrt(5e-3) *
                             std::pow(std::max(0.0, 4e-3 * share - 1e-3), 1.5) +
                         noise(random));
    raw.line.push_back(static_cast<std::size_t>(i) + 2);
  }
  return raw;
}

/// The text of the Error; empty where the recording is read.
inline std::string refusal_of(const importers::RawRecording& raw,
                              const std::optional<Vec3>& inward) {
  try {
    condition(raw, {}, inward, "a.csv");
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace palpate::recordings::testing_signal
