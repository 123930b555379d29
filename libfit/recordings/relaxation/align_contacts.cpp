#include "libfit/recordings/relaxation/align_contacts.hpp"

#include <algorithm>
#include <cmath>

#include "libfit/recordings/relaxation/series_covariance.hpp"

namespace palpate::recordings {
namespace {

constexpr double kKnown_m2 = 1e-24;  // variance of a contact that is known

}  // namespace

std::vector<ContactShift> align_contacts(const std::vector<RelaxingPress>& presses,
                                         const Relaxation& relaxation, SlowCurve curve) {
  std::vector<ContactShift> out(presses.size());
  for (std::size_t r = 0; r < presses.size(); ++r)
    out[r].deviation_m = presses[r].contact_deviation_m;
  const SeriesSearch search({presses}, curve, relaxation.time_s.minCoeff(),
                            relaxation.time_s.maxCoeff());
  const PressGroup& group = search.groups()[0];
  if (group.shifts() == 0) return out;
  const SeriesValues values = search.aligned(relaxation);
  const Eigen::MatrixXd covariance = series_covariance(search, values, true);
  // Against the first recording: each contact that was found is a reading of the one they share.
  double weights = 0, common_m = 0;
  std::vector<double> shift_variance(presses.size(), 0);
  for (std::size_t r = 0; r < presses.size(); ++r) {
    const double deviation_m = presses[r].contact_deviation_m;
    if (const int k = group.shift_of(r); k >= 0) {
      out[r].moved_m = values.shift[0][static_cast<std::size_t>(k)] * deviation_m;
      const Eigen::Index at = 2 * relaxation.branches() + k;
      shift_variance[r] = covariance(at, at) * deviation_m * deviation_m;
    }
    const double weight = 1 / std::max(deviation_m * deviation_m, kKnown_m2);
    weights += weight, common_m -= weight * out[r].moved_m;
  }
  common_m /= weights;
  for (std::size_t r = 0; r < presses.size(); ++r) {
    out[r].moved_m += common_m;
    out[r].deviation_m = std::sqrt(1 / weights + shift_variance[r]);
  }
  return out;
}

}  // namespace palpate::recordings
