#pragma once

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "libfit/recordings/signal/signal.hpp"

namespace palpate::recordings {

// Numbers that the estimators share.
inline constexpr int kContactSteps = 8;            ///< trial contact points between two means
inline constexpr double kTouchCost = 10;           ///< log odds against beginning in contact
inline constexpr double kDigits = 1e-5;            ///< of the full force: readings have no more
inline constexpr double kHolds = 1.5;              ///< residual over noise up to which a law holds
inline constexpr double kCorrelationByChance = 2;  ///< deviations, of white noise

inline double square(double x) { return x * x; }

/// The way in as B means over equal steps of travel: B values each, travel increasing.
struct PressCurve {
  Eigen::VectorXd travel_m, push_N, count;
  double noise_N = 0;    ///< standard deviation of one mean, without contact
  double quantum_N = 0;  ///< step of a coarse sensor, whose readings repeat values; else 0
  /// Share of the largest push that a power law must explain, however well it fits less.
  double least_explained = 0;
};

/// A contact point by an estimator; what its model cannot know is not in the deviation.
struct ContactEstimate : FoundContact {
  bool begins_in_contact = false;  ///< no free travel was recorded: travel_m is its first row
  double amplitude = 0;      ///< a of push = a depth^exponent [N/m^exponent]; 0 without such a fit
  std::string_view by = {};  ///< the estimator that `auto` took; empty of the others
};

/// A row of the table of estimators.
struct ContactEstimator {
  std::string_view name;
  ContactEstimate (*estimate)(const PressCurve& curve, const SignalSettings& settings);
};

/// All estimators. Precondition of each: at least 5 means, and a push that rises.
std::span<const ContactEstimator> contact_estimators();
const ContactEstimator* contact_estimator_named(std::string_view name);

/// B <= `most` means of rows over equal steps of travel; empty steps are left out.
PressCurve mean_curve(const Eigen::VectorXd& travel_m, const Eigen::VectorXd& push_N, int most);

/// Exponent of a tip on a half-space: 3/2, 1 or 2 (Hertz 1881, Boussinesq 1885, Sneddon 1965).
double exponent_of(Tip tip);

/// Contact point of a curve of which nothing is known but that it is smooth and begins rising:
///   push = bias before contact, and from there on the integral of a slope that wanders
/// (a Wiener process of unknown intensity: the cubic smoothing spline). Mean and deviation of its
/// posterior, flat in the contact point, the bias, the first slope (which is not negative) and the
/// logarithm of the intensity; the noise is the curve's own, and where free means go together their
/// number is less. Costs one pass over the means for each of 24 intensities. amplitude is 0.
/// Preconditions: at least 5 means, and a push that rises.
/// Source: Wahba (1978), doi:10.1111/j.2517-6161.1978.tb01050.x (splines as posterior means);
/// Durbin and Koopman (2012), Time Series Analysis by State Space Methods, 4.3 (the filter).
ContactEstimate contact_of_smooth_curve(const PressCurve& curve, const SignalSettings&);

/// A law's contact point, and what its best fit leaves.
struct LawFit {
  ContactEstimate contact;
  double squares = 0;  ///< sum over readings [N^2]
  double rms_N = 0;    ///< of the means
};

/// Contact point over the first means of a curve, less a slope, of a tip whose body stiffens or
/// softens, smoothly and by any amount:
///   push = bias + a depth^exponent (1 + s1 x + s2 x^2 + s3 x^3), x = depth over the largest one
/// Mean and deviation of the posterior, flat in contact point, bias and a > 0, averaged over how
/// far s1 to s3 may be from 0. The noise is the curve's own or what the law leaves, whichever is
/// more; residuals that go together count as fewer. amplitude is 0. Some 4 ms for 400
/// means. Precondition: at least 8 means, and a push that rises. Source: MacKay (1992),
/// doi:10.1162/neco.1992.4.3.415 (models averaged by their evidence).
LawFit contact_of_stiffening_law(const PressCurve& curve, Eigen::Index means, double exponent,
                                 double slope_N_m);

/// Contact point of a curve that an exponential explains to its noise, as soft tissue's often are:
///   push = bias + a (exp(depth / length) - 1)
/// Mean and deviation over all contact points and lengths, and over the power laws of `exponents`,
/// by their likelihood; a is the best of each. Where the toe is below the noise this says so: the
/// contact may lie anywhere before the curve rises. Nothing where an exponential does not explain
/// the curve, or not clearly better than something else does (squares_to_beat, sum over readings).
/// Source: Fung (1967), doi:10.1152/ajplegacy.1967.213.6.1532.
std::optional<LawFit> contact_of_simple_law(const PressCurve& curve,
                                            std::span<const double> exponents,
                                            double squares_to_beat);

/// The minimum of a function that falls, then rises between a and b, by golden sections.
template <class Value>
double minimum_between(double a, double b, int sections, const Value& value) {
  constexpr double kGolden = 0.6180339887498949;
  double c = b - kGolden * (b - a), d = a + kGolden * (b - a), at_c = value(c), at_d = value(d);
  for (int i = 0; i < sections; ++i) {
    if (at_c < at_d) {
      b = d, d = c, at_d = at_c;
      at_c = value(c = b - kGolden * (b - a));
    } else {
      a = c, c = d, at_c = at_d;
      at_d = value(d = a + kGolden * (b - a));
    }
  }
  return (a + b) / 2;
}

/// push = bias + slope (travel - first) + a max(travel - contact, 0)^exponent over the first means
/// of a curve, fitted for each contact point. Refers to the curve.
class PowerProfile {
 public:
  /// has_slope: of the free part, which a drift or light in the cantilever tilts; else it is 0.
  PowerProfile(const PressCurve& curve, Eigen::Index means, double exponent, bool has_slope = false)
      : curve_(curve), means_(means), exponent_(exponent), has_slope_(has_slope) {}

  struct AmplitudeFit {
    double squares = kInfinity, bias_N = 0, amplitude = 0, slope_N_m = 0;
  };

  /// Least squares at one contact point; infinite squares where a is not positive.
  AmplitudeFit at(double contact_m) const;
  /// The best contact point, from one range before the curve to its end. Trials lie denser towards
  /// the end: a press may be a thousandth of its travel.
  double best_contact_m() const;
  double rms_N(double contact_m, const AmplitudeFit& fit) const;
  /// Standard deviation, from the curvature of the profile; residuals that go together count as
  /// fewer. At most the range.
  double deviation_m(double contact_m, const AmplitudeFit& fit) const;

 private:
  double residual(Eigen::Index i, double contact_m, const AmplitudeFit& fit) const;
  double basis(Eigen::Index i, double contact_m) const;
  double correlation_time(double contact_m, const AmplitudeFit& fit) const;

  const PressCurve& curve_;
  Eigen::Index means_;
  double exponent_;
  bool has_slope_;
};

/// The least-squares contact point of the power law over the whole curve, with a slope of the free
/// part where that is half the curve or more and the slope explains much of the misfit.
double contact_of_whole_curve_m(const PressCurve& curve, double exponent);

}  // namespace palpate::recordings
