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

/// True where error_N [N] is at most max(0.04 N, 7 % of force_N), as within_jnd counts it.
bool is_within_threshold(double error_N, double force_N);

}  // namespace palpate
