#pragma once

#include <string>
#include <vector>

namespace palpate {

/// A row of data/perception.toml, which travels inside the program: the least difference that a
/// person notices. A number that is not known is NaN.
struct Threshold {
  std::string name;
  double share = 0;                    ///< of what is compared
  double least_N = 0;                  ///< forces and differences up to it are not noticed
  double angle_deg = 0;                ///< of directions
  std::string condition, source, doi;  ///< doi may be empty
};
const std::vector<Threshold>& thresholds();

/// The numbers of that table which results are judged by.
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
