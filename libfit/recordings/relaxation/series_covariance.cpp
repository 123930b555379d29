#include "libfit/recordings/relaxation/series_covariance.hpp"

#include "libfit/core/linear_algebra.hpp"
#include "libfit/recordings/relaxation/sensor_noise.hpp"

namespace palpate::recordings {

Eigen::MatrixXd series_covariance(const SeriesSearch& with, const SeriesValues& values,
                                  bool is_series_known) {
  const Eigen::Index branches = values.branches();
  Eigen::Index unknowns = 2 * branches;
  for (const PressGroup& group : with.groups()) unknowns += group.shifts();
  std::vector<Eigen::Index> free;
  for (Eigen::Index k = is_series_known ? 2 * branches : 0; k < unknowns; ++k) {
    if (k >= branches && k < 2 * branches)
      if (const double at = values.branch[static_cast<std::size_t>(k)];
          with.is_slowest(at) || with.is_fastest(at))
        continue;
    free.push_back(k);
  }
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(unknowns, unknowns), noise = information;
  Eigen::Index first = 2 * branches;  // of the group's shifts
  for (std::size_t g = 0; g < with.groups().size(); ++g) {
    const PressGroup& group = with.groups()[g];
    const Eigen::Index shifts = group.shifts();
    const SeriesSearch::Slopes slopes = with.slopes(g, values);
    const Eigen::MatrixXd inner = with.solution(g, values).slopes;
    Eigen::MatrixXd outer = Eigen::MatrixXd::Zero(group.residuals(), unknowns);
    outer.leftCols(2 * branches) = slopes.by_branch;
    outer.middleCols(first, shifts) = slopes.by_shift;
    information += outer.transpose() * outer;
    const Eigen::MatrixXd priors = outer.bottomRows(group.priors());
    noise += priors.transpose() * priors;
    for (std::size_t r = 0; r < group.recordings(); ++r) {
      const PressGroup::FittedRows rows = group.counted(r);
      const Eigen::MatrixXd by = outer(rows.row, Eigen::all);
      Eigen::MatrixXd all(by.rows(), 2 * branches + shifts + inner.cols());
      all << by.leftCols(2 * branches), by.middleCols(first, shifts), inner(rows.row, Eigen::all);
      noise +=
          by.transpose() *
          sensor_covariance(rows.time_s, rows.noise, rows.weight, slopes.residual(rows.row), all) *
          by;
    }
    first += shifts;
  }
  const Eigen::MatrixXd inverse = ldlt_inverse(information(free, free));
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(unknowns, unknowns);
  covariance(free, free) = inverse * noise(free, free) * inverse;
  return covariance;
}

}  // namespace palpate::recordings
