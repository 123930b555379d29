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
  double mass_kg = 0;     ///< apparent, at the tip
};

/// Rates that a servo loop may have [Hz].
constexpr int kRates_Hz[] = {1000, 2000, 4000, 10000};

/// Damping [N s/m] that a device must have of its own to show a stiffness K at a rate with nobody's
/// help, K T / 2 (M23); the engine's damper has to be paid beside it.
/// Source: Colgate and Schenkel 1997.
double least_damping_Ns_m(double stiffness_N_m, double rate_Hz);

/// A servo loop around a device that shows a spring, in a hand that presses on it.
struct ServoLoop {
  double rate_Hz = 1000;
  int delay_ticks = 1;  ///< from reading the encoder to the force, beside the hold
  int hands = 24;
  unsigned seed = 1;
};

/// Number of the loop's hands with which the force keeps swinging by more than is noticed (0.04 N),
/// a second after the hand has come to rest. A hand is mass, damper and spring, drawn evenly on
/// logarithms of 50 to 300 g, 1 to 10 N s/m and 50 to 800 N/m; it presses with half of force_N, or
/// of what the device can. Device and hand move as one mass with the device's Coulomb friction, in
/// steps of a twentieth of a tick; the encoder rounds down. The spring pushes only.
int swinging_hands(const Device& device, double stiffness_N_m, double force_N,
                   const ServoLoop& loop = {});

/// Verdict on a device for a body.
struct DeviceVerdict {
  Device device;
  bool force_fits = true;      ///< its force is the largest of the body's, or more
  bool stiffness_fits = true;  ///< and its stiffness
  /// Friction is K resolution / 2 or more (M24), so that steps of the encoder make no motion of
  /// their own; true where friction or resolution is not stated.
  bool resolution_fits = true;
  int hands = 0, swinging = 0;  ///< of swinging_hands(); no hands where the mass is not stated
};

/// Source: Abbott and Okamura 2005.
DeviceVerdict judge(const Device& device, double stiffness_N_m, double force_N);

}  // namespace palpate::certify
