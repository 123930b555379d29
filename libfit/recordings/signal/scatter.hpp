#pragma once

#include <string>

#include "libfit/core/geometry.hpp"

namespace palpate::recordings {

/// Standard deviation of neighbouring values about straight lines through three of them: the noise
/// of a signal that bends slowly. 0 below three values.
double neighbour_scatter(const Eigen::VectorXd& values);

/// Least difference between values of a sensor so coarse that neighbours are often equal; else 0.
/// Precondition: at least one value.
double quantum_of(const Eigen::VectorXd& values);

/// Least squares y = at_0 + slope x without what lies five robust deviations off; deviation of the
/// residuals, and how far neighbours among them go together (their correlation).
struct Line {
  double at_0 = 0, slope = 0, deviation = 0, correlation = 0;
};
Line fit_line(const Eigen::VectorXd& x, const Eigen::VectorXd& y);

}  // namespace palpate::recordings
