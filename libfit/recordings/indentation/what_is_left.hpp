#pragma once

#include <Eigen/Core>

namespace palpate::recordings {

// What a fit leaves of W readings, one after the other: noise, drift, or the wrong model.

/// Rows per independent one, by how residuals go together: 1 + 2 (r1 + r2 + ...) until the first
/// that is not positive.
double correlation_time(const Eigen::VectorXd& left);

/// Covariance of the unknowns whose columns these are (W x p): readings have noise of their own and
/// drift whose power goes as 1/f, which bends as the curve does (sensor_covariance). On means of
/// neighbouring rows.
Eigen::MatrixXd covariance_of(const Eigen::MatrixXd& columns, const Eigen::VectorXd& left);

/// Variance of one reading's noise, by its neighbours.
double noise_variance(const Eigen::VectorXd& left);

inline constexpr int kParts = 20;  ///< of a travel, over which misfits are averaged

/// Means of what is left over equal parts of a travel.
struct PartMeans {
  Eigen::VectorXd mean, count;  ///< kParts; a mean of none is 0

  double rms() const;
  int runs() const;  ///< of one sign, among the parts that have rows
};
PartMeans part_means(const Eigen::VectorXd& x, const Eigen::VectorXd& left, double from, double to);

/// Root mean square of those means, less what noise (a variance) leaves in them.
double misfit_of(const PartMeans& parts, double noise);

/// Whether what is left goes with depth beyond the contact, and is no noise: in few runs of one
/// sign or by more than noise, and by more than the free part's own waves. force: at the end of the
/// travel x (W), as the model has it.
bool has_pattern(const Eigen::VectorXd& x, const Eigen::VectorXd& left, double contact,
                 double force);

}  // namespace palpate::recordings
