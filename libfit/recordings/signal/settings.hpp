#pragma once

#include <limits>
#include <optional>
#include <string>

#include "libfit/core/samples.hpp"

namespace palpate::recordings {

/// What is taken off the force before contact: nothing, its mean, or its line over travel.
enum class Drift { none, bias, line };

/// Shape of the tip that pressed, for the contact estimate: force grows as depth to the power
/// 3/2 (sphere), 1 (flat) or 2 (cone).
enum class Tip { sphere, flat, cone };

/// The part of a press that gives its rows: the loading that goes farthest, the unloading after it,
/// or the mean of all loadings and unloadings as far (the middle of the loop, on all readings).
enum class Use { approach, retract, mean };

inline constexpr int kDeepestCycle = 0, kLastCycle = -1;

/// A contact point in the recording's own travel, and what found it.
struct FoundContact {
  double travel_m = 0, deviation_m = 0;
  std::string estimator = "given";  ///< that by the rig, or by its settings
  bool operator==(const FoundContact&) const = default;
};

/// The end of the tool that a recording was made with.
struct UsedTip {
  Tip tip = Tip::sphere;
  double radius_m = 0, half_angle_rad = 0;  ///< 0: unknown, or no cone
  bool operator==(const UsedTip&) const = default;
};

/// Corrections of a rig's readings before anything else is done with them.
struct SensorSettings {
  double force_delay_s = 0;   ///< the force signal is this late
  double compliance_m_N = 0;  ///< of the rig: travel that the body does not see
  double force_limit_N = std::numeric_limits<double>::infinity();  ///< of the sensor
  bool operator==(const SensorSettings&) const = default;
};

/// Apparent moduli outside are questioned.
struct PlausibleModuli {
  double min_young_Pa = 10, max_young_Pa = 5e6;
  bool is_range_given = false;  ///< by the user: recordings are not questioned by each other then
  bool operator==(const PlausibleModuli&) const = default;
};

/// How the signals of one recording become samples.
struct SignalSettings : UsedTip, SensorSettings, PlausibleModuli {
  ExperimentKind kind = ExperimentKind::press;
  std::string contact = "auto";                    ///< a name of kContactEstimators
  std::optional<FoundContact> known_contact = {};  ///< by the rig; nothing is estimated then
  Drift drift = Drift::bias;
  /// Positions are of the tip's centre: where it touches lies a radius further inward. Of
  /// recordings with three axes, and tips with a radius alone.
  bool is_position_of_center = false;
  double poisson = 0.5;  ///< of the body
  double smooth_s = 0;   ///< standard deviation of the Gaussian filter, which has no delay
  Use use = Use::approach;
  /// Of the presses of a recording that go as deep: its number from 1 on, kLastCycle, or
  /// kDeepestCycle, the one that goes farthest.
  int cycle = kDeepestCycle;
  int rows = 40;  ///< per experiment, at most
  bool operator==(const SignalSettings&) const = default;
};

}  // namespace palpate::recordings
