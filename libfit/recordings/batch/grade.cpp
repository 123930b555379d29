#include "libfit/recordings/batch/grade.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "libfit/core/text.hpp"
#include "libfit/recordings/signal/scatter.hpp"

namespace palpate::recordings {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kMinSignal = 20;       // force over noise of a fair recording
constexpr double kContactShare = 0.02;  // contact deviation over depth of a good recording

}  // namespace

void grade(const SignalSettings& settings, const ContactEstimate& contact, double correlation,
           Conditioned& out) {
  const auto note = [&](Grade least, const std::string& reason) {
    out.grade = std::max(out.grade, least);
    out.reasons.push_back(reason);
  };
  const auto good =
      static_cast<Eigen::Index>(std::count(out.status.begin(), out.status.end(), RowStatus::good));
  double depth_m = 0, force_N = 0;
  for (Eigen::Index i = 0; i < out.deflection_m.rows(); ++i)
    if (out.status[static_cast<std::size_t>(i)] == RowStatus::good) {
      depth_m = std::max(depth_m, out.deflection_m.row(i).norm());
      force_N = std::max(force_N, out.force_N.row(i).norm());
    }
  if (good < out.deflection_m.rows())
    note(Grade::fair, std::to_string(out.deflection_m.rows() - good) + " of " +
                          std::to_string(out.deflection_m.rows()) + " rows are saturated");
  if (force_N < kMinSignal * out.noise_N)
    note(Grade::poor, "the largest force is " + number(force_N / out.noise_N) + " times the noise");
  if (depth_m > 0 && contact.deviation_m > kContactShare * depth_m)
    note(contact.deviation_m > 5 * kContactShare * depth_m ? Grade::poor : Grade::fair,
         "the contact point is uncertain by " + number(100 * contact.deviation_m / depth_m) +
             " % of the depth");
  if (out.dropped_rows > 0)
    note(Grade::fair, std::to_string(out.dropped_rows) + " unusable rows were left out");
  if (correlation > 0.9)
    note(Grade::fair, "the noise before contact is a slow wave (neighbours correlate by " +
                          number(correlation) + ")");
  out.apparent_Pa = apparent_modulus_Pa(force_N, depth_m, settings);
}

double apparent_modulus_Pa(double force_N, double depth_m, const SignalSettings& settings) {
  if (!(force_N > 0) || !(depth_m > 0)) return kNan;
  const double elastic = 1 - 0.25;  // nu = 1/2
  if (settings.radius_m <= 0) return force_N / (depth_m * depth_m);
  return settings.tip == Tip::flat
             ? elastic * force_N / (2 * settings.radius_m * depth_m)
             : 0.75 * elastic * force_N / (std::sqrt(settings.radius_m * depth_m) * depth_m);
}

}  // namespace palpate::recordings
