#pragma once

#include <span>
#include <string_view>

#include "libfit/core/geometry.hpp"
#include "libfit/recordings/signal/settings.hpp"

namespace palpate::recordings {

/// The way in as B means over equal steps of travel: B values each, travel increasing.
struct PressCurve {
  Eigen::VectorXd travel_m, push_N, count;
  double noise_N = 0;    ///< standard deviation of one mean, without contact
  double quantum_N = 0;  ///< step of a coarse sensor, whose readings repeat values; else 0
};

/// Where the tip touched first.
struct ContactEstimate {
  double travel_m = 0;
  double deviation_m = 0;          ///< standard deviation; what the model cannot know is not in it
  bool begins_in_contact = false;  ///< no free travel was recorded: travel_m is its first row
  double amplitude = 0;  ///< a of push = a depth^exponent [N/m^exponent]; 0 without such a fit
  double bias_N = 0;     ///< push before contact, by the same fit
};

/// A row of the table of estimators.
struct ContactEstimator {
  std::string_view name;
  std::string_view summary;
  ContactEstimate (*estimate)(const PressCurve& curve, const SignalSettings& settings);
};

/// All estimators. Precondition of each: at least 5 means, and a push that rises.
std::span<const ContactEstimator> contact_estimators();
const ContactEstimator* contact_estimator_named(std::string_view name);

/// B <= `most` means of rows over equal steps of travel; empty steps are left out.
PressCurve mean_curve(const Eigen::VectorXd& travel_m, const Eigen::VectorXd& push_N, int most);

/// Exponent of a tip on a half-space: 3/2, 1 or 2 (Hertz 1881, Boussinesq 1885, Sneddon 1965).
double exponent_of(Tip tip);

}  // namespace palpate::recordings
