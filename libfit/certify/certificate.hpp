#pragma once

#include <cstdint>
#include <string>

#include "libfit/runtime/engine.hpp"

namespace palpate::certify {

struct SlideOptions {
  double radius_m = 0;   ///< of the ball that slides; 0: a tip
  double step_m = 5e-5;  ///< of a tick: 50 mm/s at 1 kHz
  int slides = 400;
  std::uint64_t seed = 1;
};

/// Largest change of the force in a tick [N], by what happened at that tick.
struct ForceJumps {
  double touch_N = 0, release_N = 0;
  double edge_N = 0;    ///< the contact point went to another triangle
  double inside_N = 0;  ///< it stayed in its own
};

/// Findings of seeded slides over an asset (docs/method-certificate.md, section 19). Sampled, not
/// bounded.
struct Certificate {
  std::int64_t ticks = 0;          ///< in contact
  std::int64_t pulling_ticks = 0;  ///< the tool was pulled in, or less than nothing was stored
  ForceJumps jumps;
  double edge_jump_at_m[3] = {0, 0, 0};  ///< contact point of jumps.edge_N
  double stiffness_N_m = 0;              ///< largest jump over a tick's step
  double force_N = 0;                    ///< largest
  std::int64_t held_ticks = 0;           ///< the guard carried a share of the force
  double refused_J = 0;                  ///< sum that slips would have created without the guard
  double work_J = 0;                     ///< sum of the work that the tool put in

  bool is_passive_fixed() const { return ticks > 0 && pulling_ticks == 0; }
};

/// Random presses, drags and lifts that begin on triangles with three measured corners, within
/// their depths. Deterministic for a seed.
Certificate certify(const runtime::AssetView& asset, const SlideOptions& options);

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
/// help, K T / 2 (M23); the engine's damper has to be paid beside it.
/// Source: Colgate and Schenkel 1997.
double least_damping_Ns_m(double stiffness_N_m, double rate_Hz);

/// Verdict on a device for a body.
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
