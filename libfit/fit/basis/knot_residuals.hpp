#pragma once

#include "libfit/fit/rows/held_out.hpp"

namespace palpate::fit {

/// Interior knots as numbers without bounds: the logarithms of h_{i+1} / h_i, where h_i is what a
/// spacing has over `least` (Jupp 1978, doi:10.1137/0715022). p pieces have p - 1 of them; every
/// spacing must exceed `least`.
Eigen::VectorXd log_ratios(const std::vector<double>& knots, double least);
/// The way back: p + 1 knots from 0 to `range`, each spacing at least `least` < range / p.
std::vector<double> knots_from(const Eigen::VectorXd& log_ratios, double range, double least);
/// d interior knots / d log ratios, p - 1 x p - 1.
Eigen::MatrixXd knots_jacobian(const Eigen::VectorXd& log_ratios, double range, double least);

/// Residuals of all points as a function of the knots alone (M5a): each point's bounded least
/// squares (M5) is solved for its own increments at the knots asked about, and what is left over
/// the point's rms force stays. A function as ceres::TinySolver wants it. Rows count as in a robust
/// fit on `reference`, a basis fine enough that what is far from it is an outlier, and no knot can
/// be moved by it. Source: variable projection, Golub and Pereyra 1973, doi:10.1137/0710036; its
/// derivative as Kaufman 1975, doi:10.1007/BF01932995, which leaves the gradient exact, projected
/// on the complement of the increments above their bound.
class KnotResiduals {
 public:
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = Eigen::Dynamic };

  /// least: of a spacing, > 0 and < range / pieces; the range and degree are those of `reference`.
  KnotResiduals(const std::vector<PointEvidence>& points, const CurveBasis& reference, int pieces,
                double least, FitLoss loss);

  int NumResiduals() const { return residuals_; }
  int NumParameters() const { return pieces_ - 1; }
  /// parameters: log ratios. jacobian: column by column, may be null.
  bool operator()(const double* parameters, double* residuals, double* jacobian) const;

  CurveBasis basis(const Eigen::VectorXd& parameters) const;
  /// Multiplies all residuals: a solver's absolute tolerances want costs of order 1.
  void scale(double factor) { scale_ *= factor; }

 private:
  struct PointResiduals {
    std::vector<double> x;
    Eigen::VectorXd weight, right;  // of rows
    double prior_strength = 0;
  };
  // Rows of a point's least squares, the weak prior's below, on a basis.
  Eigen::MatrixXd system(const PointResiduals& point, const CurveBasis& basis,
                         const SplineTables& tables) const;

  std::vector<PointResiduals> points_;
  int degree_, pieces_, residuals_ = 0;
  double range_, min_, scale_ = 1;
};

}  // namespace palpate::fit
