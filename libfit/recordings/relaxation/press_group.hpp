#pragma once

#include <vector>

#include "libfit/core/body.hpp"
#include "libfit/recordings/relaxation/timed_press.hpp"

namespace palpate::recordings {

/// What the curve of slow motion is made of: sums with weights >= 0 of powers 1, 3/2, 2 and 3 of
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
  Solution solve(const Relaxation& relaxation, const double* shifts,
                 const std::vector<char>& held_out) const;

  /// Forces of the curve's parts on all rows, and those on a recording's rows put among them.
  Eigen::MatrixXd parts(const Relaxation& relaxation, const double* shifts) const;
  void put_parts(std::size_t recording, const Relaxation& relaxation, const double* shifts,
                 Eigen::MatrixXd& parts) const;
  Solution solve(const Eigen::MatrixXd& parts, const double* shifts,
                 const std::vector<char>& held_out) const;

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
  struct PressInGroup {
    Eigen::VectorXd time_s, depth_m;
    Eigen::Index first = 0;
    int shift = -1;  ///< index of its shift
    double contact_deviation_m = 0;
    /// What the sensor drifts by over the recording, where it is not told by free parts on both
    /// sides: expected value and its deviation [N]; a deviation of 0: nothing is known beforehand.
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

/// argmin |A x - b|^2 over x >= 0, from the Gram matrix A'A (n x n) and A'b. Equal columns are
/// taken once. Source: Lawson and Hanson, Solving Least Squares Problems (1974), 23.3.
Eigen::VectorXd nonnegative_least_squares(const Eigen::MatrixXd& gram,
                                          const Eigen::VectorXd& right);

}  // namespace palpate::recordings
