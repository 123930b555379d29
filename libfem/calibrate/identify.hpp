#pragma once

#include <Eigen/Core>
#include <cmath>
#include <functional>
#include <vector>

#include "libfem/materials/materials.hpp"
#include "libfit/core/progress.hpp"

namespace palpate::fem {

/// Measured values that a material is identified from. value: N [N]. deviation: N, stated
/// standard deviations of one unit with value; NaN where none is stated, taken from those that are.
/// group: N, the experiment of each, whose rows follow one another. shared: N, how much one
/// standard deviation of an error that the rows of an experiment share, such as that of its
/// contact, moves each; empty or 0: nothing.
struct Observations {
  Eigen::VectorXd value, deviation, shared = {};
  std::vector<int> group;
};

/// The responses of each of some materials to all observations; an empty vector where it has none.
using MaterialResponses =
    std::function<std::vector<Eigen::VectorXd>(const std::vector<MaterialParameters>&)>;

/// Visits the runs of equal numbers in `group` with the first row and the number of rows of each.
template <class Visit>
void visit_groups(const std::vector<int>& group, const Visit& visit) {
  for (Eigen::Index first = 0, end = 0; first < std::ssize(group); first = end) {
    while (end < std::ssize(group) && group[end] == group[first]) ++end;
    visit(first, end - first);
  }
}

/// free: indices of the values to find. may_scale: the material's moduli are all that there are, so
/// that a common factor of them is a factor of every response. common_error: relative deviation
/// that all responses share.
struct IdentifyOptions {
  std::vector<std::size_t> free;
  bool may_scale = true;
  double common_error = 0;
  Progress progress = {};
};

/// A material found. covariance, correlation: of the free parameters, in their own units (M44).
struct Identification {
  MaterialParameters material;
  std::vector<std::size_t> free;
  Eigen::MatrixXd covariance, correlation;
  double region = 0;  ///< squared Mahalanobis distance of the 95 % region of all free parameters
  double half_width = 0;  ///< of a parameter's own 95 % interval, in deviations
  double misfit = 0;      ///< root of the mean weighted square of residuals: 1 as stated
  double rows_each = 1;   ///< rows that go together as one, where residuals are larger than stated
  double sum_of_squares = 0;  ///< of residuals, unweighted
  /// Of each experiment that has a shared error, in the order of its rows: its size in its stated
  /// standard deviations. Where they are larger than 1.1 (rms), those were too small: all are
  /// widened alike until they are not.
  std::vector<double> shared_error;
  Eigen::VectorXd response;  ///< N
  /// Every combination of relative changes is determined to a half.
  bool are_told_apart = true;
  bool is_converged = false, is_stopped = false;

  double deviation(std::size_t k) const { return std::sqrt(covariance(k, k)); }
};

/// The parameters that may be free, in the law's order: all numbers given but Poisson's ratio, the
/// bulk modulus and directions.
std::vector<std::size_t> identifiable(const MaterialParameters& material);

/// Nonlinear least squares (Levenberg-Marquardt) over the parameters (M43), from those of `start`
/// times the factor that fits best. Positive parameters are sought by their logarithm.
/// Preconditions: `start` is stable and has a value for every row of its law; `free` is neither
/// empty nor longer than the observations.
Identification identify(const MaterialParameters& start, const Observations& observed,
                        const MaterialResponses& responses, const IdentifyOptions& options);

}  // namespace palpate::fem
