#pragma once

#include <limits>

#include "libfit/recordings/contact_point/contact_point.hpp"

namespace palpate::recordings {

/// push = bias + a max(travel - contact, 0)^exponent over the first means of a curve, fitted for
/// each contact point. Refers to the curve.
class PowerProfile {
 public:
  PowerProfile(const PressCurve& curve, Eigen::Index means, double exponent)
      : curve_(curve), means_(means), exponent_(exponent) {}

  struct Fit {
    double squares = std::numeric_limits<double>::infinity(), bias_N = 0, amplitude = 0;
  };

  /// Least squares at one contact point; infinite squares where a is not positive.
  Fit at(double contact_m) const;
  /// The best contact point, from one range before the curve to its end.
  double best_contact_m() const;
  double rms_N(double contact_m, const Fit& fit) const;
  /// Standard deviation, from the curvature of the profile; residuals that go together count as
  /// fewer. At most the range.
  double deviation_m(double contact_m, const Fit& fit) const;

 private:
  double residual(Eigen::Index i, double contact_m, const Fit& fit) const;
  double basis(Eigen::Index i, double contact_m) const;
  double correlation_time(double contact_m, const Fit& fit) const;

  const PressCurve& curve_;
  Eigen::Index means_;
  double exponent_;
};

}  // namespace palpate::recordings
