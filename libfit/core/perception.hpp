#pragma once

namespace palpate {

/// Least differences that a person notices, of data/perception.toml, which travels inside the
/// program and has conditions and sources.
struct Perception {
  double force_at_rest,
      force_in_motion;   ///< shares of a force; in motion: of a contact that slides
  double force_floor_N;  ///< a force that a person does not notice
  double direction_deg;
  double torque;  ///< share
};
const Perception& perception();

/// True if a person does not notice that force_N [N] is off by error_N.
bool is_within_threshold(double error_N, double force_N, bool is_in_motion = false);

}  // namespace palpate
