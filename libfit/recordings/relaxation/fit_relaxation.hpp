#pragma once

#include <vector>

#include "libfit/core/body.hpp"
#include "libfit/recordings/signal/signal.hpp"

namespace palpate::recordings {

/// Forces on rings of unit stiffness that a tool touches at n depths and presses along a path of T
/// places, between which it moves at constant speed (M50); T x n [m], never below 0. A ring is
/// touched where the tool is deeper than it. On a way back it stays behind as long as the body
/// follows slower than the tool leaves, and then its force is 0. Exact in time, up to rounding.
/// A path that begins in contact begins relaxed. time_s: T, rising. No branches: depth beyond the
/// ring.
Eigen::MatrixXd ring_forces(const Eigen::VectorXd& time_s, const Eigen::VectorXd& depth_m,
                            const Relaxation& relaxation, const Eigen::VectorXd& ring_depth_m);

/// Stiffness of the body over that in slow motion, at times since a step: 1 + sum g e^(-t/tau).
Eigen::VectorXd stiffening(const Relaxation& relaxation, const Eigen::VectorXd& time_s);

/// Parts of the curve of slow motion: sums with weights >= 0 of powers 1, 3/2, 2 and 3 of
/// depth beyond a few contact points, or of many straight lines that begin at depths of their own.
/// Either is a rising bed of rings (B0).
enum class SlowCurve { powers, free };

/// Recordings of one point, which share their curve of slow motion: forces are linear in it, so for
/// given relaxation and shifts of contact it follows by least squares.
class PressGroup {
 public:
  PressGroup(const std::vector<TimedPress>& presses, SlowCurve curve);

  /// Rows of all recordings, and for each shift and each drift that has one its prior.
  Eigen::Index residuals() const { return rows_ + priors(); }
  Eigen::Index priors() const { return shifts() + drifts_; }
  /// Contact of the second and of later recordings against the first, in deviations; none where the
  /// contact is known.
  Eigen::Index shifts() const { return shifted_.size(); }
  Eigen::Index rows() const { return rows_; }
  /// Stretches of time of equal numbers of rows in contact, that are held out as a whole; -1 of
  /// rows that are not in contact.
  const std::vector<int>& stretch() const { return stretch_; }
  int stretches() const { return stretches_; }

  /// What is left of each row, over its deviation, where curve, level and drift of the sensor fit
  /// the other rows best (M51). held_out: of each row, whether it does not count in that; its
  /// residual is a prediction's. shifts: in deviations.
  struct Solution {
    Eigen::VectorXd residual;  ///< residuals()
    Eigen::VectorXd fitted_N;  ///< rows()
    Eigen::VectorXd curve;     ///< weights of the slow curve's parts, >= 0
    /// Residuals by curve, level and drift; rows() x unknowns that are not at their bounds.
    Eigen::MatrixXd slopes;
  };
  Solution solve(const Eigen::MatrixXd& parts, const double* shifts,
                 const std::vector<char>& held_out) const;

  /// Forces of the curve's parts on all rows, and those on a recording's rows put among them.
  Eigen::MatrixXd parts(const Relaxation& relaxation, const double* shifts) const;
  void put_parts(std::size_t recording, const Relaxation& relaxation, const double* shifts,
                 Eigen::MatrixXd& parts) const;

  std::size_t recordings() const { return presses_.size(); }
  /// Of a recording's rows within all rows.
  Eigen::Index first_row(std::size_t recording) const { return presses_[recording].first; }
  /// Index of a recording's shift; -1: it has none.
  int shift_of(std::size_t recording) const { return presses_[recording].shift; }
  /// Rows of a recording that count in a fit.
  struct FittedRows {
    std::vector<Eigen::Index> row;  ///< within all rows
    Eigen::VectorXd time_s;
    Eigen::VectorXd weight;  ///< residual per newton
    Eigen::VectorXd noise;   ///< deviation of the residual, by that of a row's readings alone
  };
  FittedRows counted(std::size_t recording) const;

 private:
  struct PressInGroup : TimedPress {
    Eigen::Index first = 0;
    int shift = -1;  ///< index of its shift
    /// The sensor's drift over the recording, where free parts on both sides do not show it:
    /// expected value and its deviation [N]; a deviation of 0: nothing is known beforehand.
    double drift_N = 0, drift_deviation_N = 0;
  };
  std::vector<PressInGroup> presses_;
  std::vector<std::size_t> shifted_;
  Eigen::Index rows_ = 0, drifts_ = 0;
  Eigen::VectorXd push_N_, noise_N_, weight_;
  std::vector<int> stretch_;
  int stretches_ = 0;
  Eigen::VectorXd ring_m_;
  Eigen::MatrixXd curve_;  // rings x coefficients
};

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
  /// True if a branch's time is at the end, or at the beginning, of what is sought.
  bool is_slowest(double log_time) const { return log_time > high_ - 0.02; }
  bool is_fastest(double log_time) const { return log_time < low_ + 0.02; }

  SeriesValues start() const;
  /// The minimum next to these values.
  SeriesValues refined(const SeriesValues& values) const;
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
  SeriesValues refined(SeriesValues values, const HeldOut& held_out, int iterations) const;

  std::vector<PressGroup> groups_;
  HeldOut none_;
  double low_, high_;  // of a logarithm of time
};

/// Covariance of the values that a search found (M52): logarithms of shares, then of times, then
/// the shifts of each group. 0 of a time at an end of what is sought.
Eigen::MatrixXd series_covariance(const SeriesSearch& with, const SeriesValues& values);

/// Covariance of the residuals of n rows in time (M52a): noise of the rows' own and drift of the
/// sensor, whose power goes as 1/f, in the proportion and of the size that restricted likelihood
/// gives, mean over proportions. noise: n, deviations by readings alone, in any unit. weight: n,
/// residual per newton. residual: n, what a linear fit by the columns of `slopes` (n x p) left.
/// Source: Patterson and Thompson, Biometrika 58 (1971).
Eigen::MatrixXd sensor_covariance(const Eigen::VectorXd& time_s, const Eigen::VectorXd& noise,
                                  const Eigen::VectorXd& weight, const Eigen::VectorXd& residual,
                                  const Eigen::MatrixXd& slopes);

/// A Prony series that recordings in time support, with 95 % intervals.
struct RelaxationFit {
  Relaxation relaxation;       ///< no branches: nothing is gained by one
  Eigen::MatrixXd covariance;  ///< 2K x 2K, of ln share and ln time, shares first (M52)
  Eigen::VectorXd share_low, share_high, time_low_s, time_high_s;  ///< K
  std::vector<char> is_slower;           ///< K: its time is at the end of what the recordings tell
  std::vector<char> is_faster;           ///< K: likewise at the beginning
  double shortest_s = 0, longest_s = 0;  ///< times that the recordings tell
  SlowCurve curve = SlowCurve::powers;
  /// Error of stretches of time that a fit did not see, over the deviation of a row, root mean
  /// square: by number of branches, as far as they were tried.
  std::vector<double> held_out;
  double rms_N = 0;  ///< of what is left of all rows

  /// Largest and least stiffening within the 95 % band at times since a step (M53).
  struct Band {
    Eigen::VectorXd low, middle, high;
  };
  Band band(const Eigen::VectorXd& time_s) const;
};

/// Identifies relaxation from recordings of points, a vector of recordings each. Nothing where no
/// recording has rows. Does not depend on threads. exactly: so many branches, without a choice; -1:
/// held-out stretches choose.
RelaxationFit fit_relaxation(const std::vector<std::vector<TimedPress>>& points, int exactly = -1);

}  // namespace palpate::recordings
