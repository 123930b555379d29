#pragma once

#include "libfit/fit/curve_rows.hpp"

namespace palpate::fit {

/// Rows with weights scaled to a mean square of 1.
std::vector<CurveRow> unit_weights(std::vector<CurveRow> rows);

/// Increments of `factor` times a curve on another basis, by least squares on its range.
Eigen::VectorXd transfer(const CurveBasis& from, const Eigen::VectorXd& increments,
                         const CurveBasis& to, double factor);

/// What one point contributes to the choice of a basis.
struct PointEvidence {
  std::vector<CurveRow> rows;  ///< of unit weights, grouped by abscissa
  double largest = 0;          ///< force
  double friction = 0;         ///< limit kind only: L / f^z overall
  Eigen::VectorXd normal;      ///< limit kind only: increments of f^z; else empty
};

/// A basis and how well its curves predict rows they did not see.
struct Candidate {
  BasisEvidence evidence;
  CurveBasis basis;
  std::vector<double> squared;  ///< weighted, of every held-out row of every point
  double mean_square = 0;
};

/// Holds out a fifth of each point's abscissae at a time. Only interpolation is judged: the deepest
/// group is always seen, and of a limit curve the shallowest too. normal: basis of f^z.
Candidate judge(const std::vector<PointEvidence>& points, const CurveBasis& normal,
                const CurveBasis& basis, bool by_curvature, FitLoss loss);

/// Whether a candidate's held-out errors exceed the best one's by no more than the tolerance or,
/// row by row, their scatter: what both leave is noise.
bool is_as_good(const Candidate& candidate, const Candidate& best, double tolerance);

}  // namespace palpate::fit
