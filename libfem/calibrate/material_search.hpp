#pragma once

#include <ceres/cost_function.h>

#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "libfem/calibrate/identify.hpp"

namespace palpate::fem {

/// The coordinate of a parameter in the search: its logarithm (times its sign) or its value over
/// `unit`.
struct Coordinate {
  std::size_t index;
  bool is_log = false;
  double unit = 1;  ///< with its sign where is_log
  double low = -std::numeric_limits<double>::infinity(),
         high = std::numeric_limits<double>::infinity();

  double to(double value) const { return is_log ? std::log(value / unit) : value / unit; }
  double from(double y) const { return unit * (is_log ? std::exp(y) : y); }
  double slope(double y) const { return is_log ? from(y) : unit; }
};

/// The weighted residuals of (M43) over coordinates of the free parameters, for Ceres, with
/// derivatives by differences and by scaling (M43a). Keeps references to responses and options.
class MaterialSearch final : public ceres::CostFunction {
 public:
  MaterialSearch(MaterialParameters start, const Observations& observed,
                 const MaterialResponses& responses, const IdentifyOptions& options);

  int size() const { return static_cast<int>(coordinates.size()); }
  MaterialParameters at(const double* y) const;
  /// The coordinates of a material, within their bounds.
  Eigen::VectorXd place(const MaterialParameters& material) const;
  bool is_refused(const MaterialParameters& material) const;
  /// Derivatives of the responses by the coordinates, N x K; nothing where a material has no
  /// answer.
  std::optional<Eigen::MatrixXd> sensitivities(const Eigen::VectorXd& y,
                                               const Eigen::VectorXd& response) const;
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;
  /// The factor of all moduli that fits best; the material itself where it may not be scaled.
  MaterialParameters scaled_to_fit(MaterialParameters material,
                                   const Eigen::VectorXd& response) const;
  /// The size at which a parameter counts: its own, or where it is nearly 0 a share of all moduli.
  double size_of(const MaterialParameters& material, std::size_t k) const;
  bool is_modulus(std::size_t index) const;
  /// Rows over their deviations, made independent (M43c): the errors that an experiment's rows
  /// share are removed. rows: N x anything.
  Eigen::MatrixXd whitened(const Eigen::MatrixXd& rows) const;
  /// Identification::shared_error of residuals N [N].
  std::vector<double> shared_error(const Eigen::VectorXd& residual) const;

  std::vector<Coordinate> coordinates;
  Eigen::VectorXd deviation;  ///< N, of the rows [N]
  bool is_stated = false, scales = false;

 private:
  Eigen::Index largest_free_modulus(const MaterialParameters& material) const;
  void make_coordinates();

  const LawRow& law_;
  MaterialParameters start_;
  Eigen::VectorXd value_;
  struct SharedError {
    Eigen::Index first, rows;
    Eigen::VectorXd weight;  // of the rows, over their deviations
  };
  std::vector<SharedError> shared_;
  const MaterialResponses& responses_;
  const IdentifyOptions& options_;
  std::vector<std::size_t> moduli_;
  double unit_sum_ = 1;
};

}  // namespace palpate::fem
