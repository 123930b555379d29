#include "libfit/recordings/contact_point/contact_point.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace palpate::recordings {
namespace {

constexpr Eigen::Index kMinMeans = 5;
constexpr std::array kExponents{1., 1.5, 2., 2.5, 3., 4.};  // of tips and bodies that are unknown
constexpr double kTiltedGain = 0.7;  // of the flat fit's squares: a slope that is worth it

// Means up to a share of the largest push over the first one.
Eigen::Index means_up_to(const PressCurve& curve, double share) {
  const double base = curve.push_N[0], limit = base + share * (curve.push_N.maxCoeff() - base);
  Eigen::Index i = 0;
  while (i < curve.push_N.size() && curve.push_N[i] <= limit) ++i;
  return std::clamp<Eigen::Index>(share >= 1 ? curve.push_N.size() : i + 1, kMinMeans,
                                  curve.push_N.size());
}

// A power law over the first means: flat before contact, or with a slope there.
struct PowerFit {
  PowerProfile profile;
  double contact_m = 0, other_m = 0;  // other: of the profile that was not taken
  PowerProfile::AmplitudeFit fit;
};

PowerFit best_power(const PressCurve& curve, double exponent, Eigen::Index means) {
  PowerFit flat{PowerProfile(curve, means, exponent), 0, 0, {}};
  flat.contact_m = flat.other_m = flat.profile.best_contact_m();
  flat.fit = flat.profile.at(flat.contact_m);
  PowerFit tilted{PowerProfile(curve, means, exponent, true), 0, flat.contact_m, {}};
  tilted.contact_m = tilted.profile.best_contact_m();
  tilted.fit = tilted.profile.at(tilted.contact_m);
  const double first = curve.travel_m[0], last = curve.travel_m[means - 1];
  const double rise_N = curve.push_N.head(means).maxCoeff() - curve.push_N[0];
  const double tilt_N = std::abs(tilted.fit.slope_N_m) * (tilted.contact_m - first);
  const bool is_free = tilted.contact_m - first > (last - first) / 2;
  // A slope of more than a tenth of the rise is the body.
  if (!std::isfinite(tilted.fit.squares) || !is_free || tilt_N > 0.1 * rise_N) return flat;
  flat.other_m = tilted.contact_m;
  return tilted.fit.squares < kTiltedGain * flat.fit.squares ? tilted : flat;
}

// stiffens: the body may stiffen or soften over the range, else it follows the power law alone.
ContactEstimate fit_up_to(const PressCurve& curve, double exponent, bool stiffens,
                          Eigen::Index means, double& rms_N) {
  auto [profile, contact_m, other_m, fit] = best_power(curve, exponent, means);
  ContactEstimate out;
  out.travel_m = contact_m;
  rms_N = profile.rms_N(out.travel_m, fit);
  if (!std::isfinite(fit.squares)) {
    out.travel_m = curve.travel_m[0];
    out.begins_in_contact = true;
    out.deviation_m = curve.travel_m[means - 1] - curve.travel_m[0];
    return out;
  }
  double deviation_m = profile.deviation_m(out.travel_m, fit);
  if (stiffens && means >= 8) {
    LawFit law = contact_of_stiffening_law(curve, means, exponent, 0);
    if (fit.slope_N_m != 0) {  // it may have stood for the stiffening
      const LawFit tilted = contact_of_stiffening_law(curve, means, exponent, fit.slope_N_m);
      if (tilted.squares < kTiltedGain * law.squares) law = tilted;
    }
    if (std::isfinite(law.contact.travel_m)) {  // forces of many decades may leave no weight
      out.travel_m = law.contact.travel_m, deviation_m = law.contact.deviation_m;
      rms_N = law.rms_N;
      fit = profile.at(out.travel_m);
    }
  }
  out.deviation_m = std::hypot(deviation_m, 0.1 * (other_m - contact_m));
  out.amplitude = fit.amplitude;
  const double first = curve.travel_m[0], step = curve.travel_m[1] - first;
  if (out.travel_m < first + step) {  // no mean without contact
    out.begins_in_contact = true;
    out.deviation_m = std::max(out.deviation_m, std::abs(out.travel_m - first));
    out.travel_m = first;
  }
  return out;
}

// The longest range that the power law still fits: a material that stiffens ends it early. Else, of
// those whose law explains enough of the largest force, the one that it fits best.
ContactEstimate fit_power(const PressCurve& curve, double exponent, bool stiffens) {
  double rms_N = 0;
  const double largest_N = curve.push_N.maxCoeff() - curve.push_N[0];
  ContactEstimate best;
  double least = kInfinity, other_m = kNan;
  for (double share = 1; share > 1e-3; share /= 2) {
    const Eigen::Index means = means_up_to(curve, share);
    const ContactEstimate fit = fit_up_to(curve, exponent, stiffens, means, rms_N);
    const double misfit = rms_N / (share * largest_N);
    const double depth_m = curve.travel_m[curve.travel_m.size() - 1] - fit.travel_m;
    const double explained = fit.amplitude * std::pow(std::max(depth_m, 0.0), exponent) / largest_N;
    // Nearer than a hundredth no tissue follows a power law.
    const bool is_good = (rms_N <= kHolds * curve.noise_N || misfit <= 0.01) &&
                         (share == 1 || explained > curve.least_explained);
    if (is_good || share == 1 || (misfit < least && explained > curve.least_explained)) {
      if (least < kInfinity) other_m = best.travel_m;
      best = fit;
      least = misfit;
    }
    // A smaller range would say little about contact.
    if (is_good || share / 2 * largest_N < 12 * curve.noise_N || means <= kMinMeans + 3) break;
  }
  // The place by a longer range shows how much the power law leaves open.
  if (!best.begins_in_contact && std::isfinite(other_m))
    best.deviation_m = std::hypot(best.deviation_m, 0.25 * (other_m - best.travel_m));
  return best;
}

// Without free travel the readings do not separate stiffening from bias: the power law alone is
// fitted. Ten compressions of silicones, recorded from contact on, have up to 7 means before it by
// that law; with the other they begin 6 mm too deep.
ContactEstimate by_hertz(const PressCurve& curve, const SignalSettings& settings) {
  const double exponent = exponent_of(settings.tip);
  const ContactEstimate plain = fit_power(curve, exponent, false);
  const Eigen::Index free = (curve.travel_m.array() < plain.travel_m).count();
  return plain.begins_in_contact || free < 10 ? plain : fit_power(curve, exponent, true);
}

// Contact point of an exponential and of the law that stiffens, each by its likelihood. Akaike's
// criterion would halve the error of exponentials, and add half to that of bodies that soften.
ContactEstimate averaged(const PressCurve& curve, const LawFit& law, double other_squares,
                         const ContactEstimate& other) {
  const double share = 1 / (1 + std::pow(law.squares / other_squares, curve.travel_m.size() / 2.0));
  const double apart_m = law.contact.travel_m - other.travel_m;
  ContactEstimate out = law.contact;
  out.travel_m -= (1 - share) * apart_m;
  out.deviation_m = std::sqrt(share * std::pow(law.contact.deviation_m, 2) +
                              (1 - share) * std::pow(other.deviation_m, 2) +
                              share * (1 - share) * apart_m * apart_m);
  return out;
}

// The power law of a tip that is known says most; without it the smooth curve alone is honest.
ContactEstimate by_auto(const PressCurve& curve, const SignalSettings& settings) {
  const ContactEstimate hertz = by_hertz(curve, settings);
  const bool is_told = settings.radius_m > 0 || settings.tip != Tip::sphere;
  const double exponent = exponent_of(settings.tip);
  const PowerProfile whole(curve, curve.travel_m.size(), exponent);
  const auto law =
      contact_of_simple_law(curve, is_told ? std::span<const double>(&exponent, 1) : kExponents,
                            is_told ? whole.at(whole.best_contact_m()).squares : kInfinity);
  if (law) {
    ContactEstimate out = law->contact;
    if (is_told)
      out = averaged(curve, *law,
                     contact_of_stiffening_law(curve, curve.travel_m.size(), exponent, 0).squares,
                     hertz);
    else
      out.deviation_m =
          std::hypot(out.deviation_m,
                     0.35 * (contact_of_smooth_curve(curve, settings).travel_m - out.travel_m));
    out.amplitude = whole.at(out.travel_m).amplitude;
    out.by = "exponentials";
    return out;
  }
  if (is_told) {
    ContactEstimate out = hertz;
    out.by = "hertz";
    return out;
  }
  ContactEstimate smooth = contact_of_smooth_curve(curve, settings);
  smooth.amplitude = hertz.amplitude;
  smooth.by = "smooth-curve";
  return smooth;
}

constexpr std::array<ContactEstimator, 3> kEstimators{
    {{"auto", by_auto}, {"hertz", by_hertz}, {"smooth-curve", contact_of_smooth_curve}}};

}  // namespace

double contact_of_whole_curve_m(const PressCurve& curve, double exponent) {
  return best_power(curve, exponent, curve.travel_m.size()).contact_m;
}

double exponent_of(Tip tip) { return tip == Tip::sphere ? 1.5 : tip == Tip::flat ? 1.0 : 2.0; }

std::span<const ContactEstimator> contact_estimators() { return kEstimators; }

const ContactEstimator* contact_estimator_named(std::string_view name) {
  const auto row = std::ranges::find(kEstimators, name, &ContactEstimator::name);
  return row == kEstimators.end() ? nullptr : &*row;
}

PressCurve mean_curve(const Eigen::VectorXd& travel_m, const Eigen::VectorXd& push_N, int most) {
  const double first = travel_m.minCoeff(), range = travel_m.maxCoeff() - first;
  const Eigen::Index bins = std::min<Eigen::Index>(most, travel_m.size());
  Eigen::VectorXd travel = Eigen::VectorXd::Zero(bins), push = travel, count = travel;
  for (Eigen::Index i = 0; i < travel_m.size(); ++i) {
    const double share = range > 0 ? (travel_m[i] - first) / range : 0;
    const auto b = std::min<Eigen::Index>(bins - 1, share * static_cast<double>(bins));
    travel[b] += travel_m[i];
    push[b] += push_N[i];
    count[b] += 1;
  }
  PressCurve curve;
  curve.quantum_N = quantum_of(push_N);
  const Eigen::Index filled = (count.array() > 0).count();
  for (Eigen::VectorXd* column : {&curve.travel_m, &curve.push_N, &curve.count})
    column->resize(filled);
  for (Eigen::Index b = 0, k = 0; b < bins; ++b) {
    if (!(count[b] > 0)) continue;
    curve.travel_m[k] = travel[b] / count[b];
    curve.push_N[k] = push[b] / count[b];
    curve.count[k++] = count[b];
  }
  return curve;
}

}  // namespace palpate::recordings
