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

/// Which way of a press gives its rows: the way in that goes farthest, the way back from it, or the
/// mean of every way in and back that goes as far (the middle of the loop, on all readings).
enum class Use { approach, retract, mean };

inline constexpr int kDeepestCycle = 0, kLastCycle = -1;

/// A contact point that is known before the signal is looked at, in the recording's own travel.
struct KnownContact {
  double travel_m = 0, deviation_m = 0;
  std::string by = "given";  ///< what knows it
};

/// How the signals of one recording become samples.
struct SignalSettings {
  ExperimentKind kind = ExperimentKind::press;
  std::string contact = "auto";                    ///< a name of kContactEstimators
  std::optional<KnownContact> known_contact = {};  ///< by the rig; nothing is estimated then
  bool has_common_contact = false;  ///< one for all presses of its point, see common_contacts
  Drift drift = Drift::bias;
  Tip tip = Tip::sphere;
  double radius_m = 0;  ///< of the tip; 0: unknown
  /// Positions are of the tip's centre: where it touches lies a radius further inward. Of
  /// recordings with three axes, and tips with a radius alone.
  bool is_position_of_center = false;
  double half_angle_rad = 0;  ///< of a cone; 0: unknown
  double poisson = 0.5;       ///< of the body
  double smooth_s = 0;        ///< standard deviation of the Gaussian filter, which has no delay
  double force_delay_s = 0;   ///< the force signal is this late
  double compliance_m_N = 0;  ///< of the rig: travel that the body does not see
  double force_limit_N = std::numeric_limits<double>::infinity();  ///< of the sensor
  Use use = Use::approach;
  /// Of the presses of a recording that go as deep: its number from 1 on, kLastCycle, or
  /// kDeepestCycle, the one that goes farthest.
  int cycle = kDeepestCycle;
  int rows = 40;                                 ///< per experiment, at most
  double min_young_Pa = 10, max_young_Pa = 5e6;  ///< apparent moduli outside are questioned
  bool is_range_given =
      false;  ///< by the user, so that recordings are not questioned by each other
};

}  // namespace palpate::recordings
