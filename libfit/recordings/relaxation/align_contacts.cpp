#include "libfit/recordings/relaxation/align_contacts.hpp"

#include <algorithm>
#include <cmath>

#include "libfit/recordings/relaxation/series_covariance.hpp"

namespace palpate::recordings {
namespace {

constexpr double kKnown_m2 = 1e-24;  // variance of a contact that is known

}  // namespace

Alignment align_contacts(const std::vector<RelaxingPress>& presses, const Relaxation& relaxation,
                         SlowCurve curve) {
  Alignment alignment;
  std::vector<ContactShift>& out = alignment.contact;
  out.resize(presses.size());
  for (std::size_t r = 0; r < presses.size(); ++r)
    out[r].deviation_m = presses[r].contact_deviation_m;
  const SeriesSearch search({presses}, curve, relaxation.time_s.minCoeff(),
                            relaxation.time_s.maxCoeff());
  const PressGroup& group = search.groups()[0];
  const SeriesValues values = search.aligned(relaxation);
  const Eigen::VectorXd weight = search.solution(0, values).curve;
  const double* shift = values.shift[0].data();
  const Eigen::VectorXd by_time_N =
      (group.parts(relaxation, shift) - group.parts({}, shift)) * weight;
  for (std::size_t r = 0; r < presses.size(); ++r) {
    const Eigen::Index first = group.first_row(r), rows = presses[r].press.rows();
    alignment.slow_push_N.emplace_back(presses[r].press.push_N - by_time_N.segment(first, rows));
  }
  if (group.shifts() == 0) return alignment;
  const Eigen::MatrixXd covariance = series_covariance(search, values, true);
  // Against the first recording: each contact that was found is a reading of the one they share.
  double precisions = 0, common_m = 0;
  std::vector<double> shift_variance(presses.size(), 0);
  for (std::size_t r = 0; r < presses.size(); ++r) {
    const double deviation_m = presses[r].contact_deviation_m;
    if (const int k = group.shift_of(r); k >= 0) {
      out[r].moved_m = values.shift[0][k] * deviation_m;
      const Eigen::Index at = 2 * relaxation.branches() + k;
      shift_variance[r] = covariance(at, at) * deviation_m * deviation_m;
    }
    const double precision = 1 / std::max(deviation_m * deviation_m, kKnown_m2);
    precisions += precision, common_m -= precision * out[r].moved_m;
  }
  common_m /= precisions;
  for (std::size_t r = 0; r < presses.size(); ++r) {
    out[r].moved_m += common_m;
    out[r].shift_deviation_m = std::sqrt(shift_variance[r]);
    out[r].deviation_m = std::sqrt(1 / precisions + shift_variance[r]);
  }
  return alignment;
}

}  // namespace palpate::recordings
