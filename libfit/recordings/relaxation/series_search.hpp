#pragma once

#include "libfit/recordings/relaxation/press_group.hpp"

namespace palpate::recordings {

/// Outer unknowns of (M51).
struct SeriesValues {
  std::vector<double> branch;              ///< logarithms of shares, then of times
  std::vector<std::vector<double>> shift;  ///< of each group

  Eigen::Index branches() const { return branch.size() / 2; }
  Relaxation relaxation() const;
};

/// Least squares (M51) over points that share a Prony series, for one kind of slow curve.
class SeriesSearch {
 public:
  /// points: a vector of recordings each. Times are sought between the two.
  SeriesSearch(const std::vector<std::vector<TimedPress>>& points, SlowCurve curve,
               double shortest_s, double longest_s);

  const std::vector<PressGroup>& groups() const { return groups_; }
  /// Whether a branch's time is at the end, or at the beginning, of what is sought.
  bool is_slowest(double log_time) const;
  bool is_fastest(double log_time) const;

  SeriesValues start() const;
  /// The minimum next to these values.
  SeriesValues refined(const SeriesValues& values) const;
  /// Shifts alone, for a series that is known.
  SeriesValues aligned(const Relaxation& relaxation) const;
  /// With one branch more: the best of a grid of trial branches, refined.
  SeriesValues with_another(const SeriesValues& from) const;

  /// Mean square of what was left of each stretch by a fit that did not see it, that starts from
  /// `found`; without iterations it saw the stretch for the branches, but not for curve and sensor.
  std::vector<double> held_out_squares(const SeriesValues& found, int iterations) const;

  /// What is left of a group's rows and of its priors, with derivatives by logarithms and shifts.
  struct Slopes {
    Eigen::VectorXd residual;
    Eigen::MatrixXd by_branch, by_shift;
  };
  Slopes slopes(std::size_t group, const SeriesValues& values) const;
  PressGroup::Solution solution(std::size_t group, const SeriesValues& values) const;

 private:
  using HeldOut = std::vector<std::vector<char>>;  // of each group's rows
  double squares(const SeriesValues& values) const;
  SeriesValues refined(SeriesValues values, const HeldOut& held_out, int iterations,
                       bool is_series_known = false) const;

  std::vector<PressGroup> groups_;
  HeldOut none_;
  double low_, high_;  // of a logarithm of time
};

/// Covariance of the values that a search found (M52): logarithms of shares, then of times, then
/// the shifts of each group. 0 of a time at an end of what is sought, and of a series that is
/// known.
Eigen::MatrixXd series_covariance(const SeriesSearch& with, const SeriesValues& values,
                                  bool is_series_known = false);

/// Covariance of the residuals of n rows in time (M52a): noise of the rows' own and drift of the
/// sensor, whose power goes as 1/f, in the proportion and of the size that restricted likelihood
/// gives, mean over proportions. noise: n, deviations by readings alone, in any unit. weight: n,
/// residual per newton. residual: n, what a linear fit by the columns of `slopes` (n x p) left.
/// Source: Patterson and Thompson, Biometrika 58 (1971).
Eigen::MatrixXd sensor_covariance(const Eigen::VectorXd& time_s, const Eigen::VectorXd& noise,
                                  const Eigen::VectorXd& weight, const Eigen::VectorXd& residual,
                                  const Eigen::MatrixXd& slopes);

}  // namespace palpate::recordings
