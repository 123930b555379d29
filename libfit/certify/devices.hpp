#pragma once

#include <string>
#include <vector>

namespace palpate::certify {

/// A haptic device as its maker or a paper states it; 0: not stated.
struct Device {
  std::string name, source;
  double max_force_N = 0;
  double max_stiffness_N_m = 0;  ///< that its maker lets it show
  double resolution_m = 0;
  double friction_N = 0;  ///< Coulomb, or back-drive friction
};

/// Rates that a servo loop may have [Hz].
constexpr int kRates_Hz[] = {1000, 2000, 4000, 10000};

/// Damping [N s/m] that a device must have of its own to show a stiffness K at a rate with nobody's
/// help, K T / 2 (M23). virtual_damping_Ns_m: of the engine's damper; it has to be paid, too.
/// Source: Colgate and Schenkel 1997.
double least_damping_Ns_m(double stiffness_N_m, double rate_Hz, double virtual_damping_Ns_m = 0);

/// What a device says to a body.
struct DeviceVerdict {
  Device device;
  bool force_fits = true;      ///< its force is the largest of the body's, or more
  bool stiffness_fits = true;  ///< and its stiffness
  /// Friction is K resolution / 2 or more (M24), so that steps of the encoder make no motion of
  /// their own; true where friction or resolution is not stated.
  bool resolution_fits = true;
};

/// Source: Abbott and Okamura 2005.
DeviceVerdict judge(const Device& device, double stiffness_N_m, double force_N);

}  // namespace palpate::certify
