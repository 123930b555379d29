#pragma once

#include "libfit/fit/report.hpp"
#include "libfit/fit/rows/curve_rows.hpp"

namespace palpate::fit {

/// What one point contributes to the choice of a basis.
struct PointEvidence {
  std::vector<CurveRow> rows;  ///< of unit weights, grouped by abscissa
  double largest = 0;          ///< force
  double friction = 0;         ///< limit kind only: L / f^z overall
  Eigen::VectorXd normal;      ///< limit kind only: increments of f^z; else empty
};

/// A basis and how well its curves predict rows they did not see.
struct BasisCandidate {
  BasisEvidence evidence;
  CurveBasis basis;
  std::vector<double> squared;  ///< weighted, of every held-out row of every point
  double mean_square = 0;
};

/// Judges `basis` by each fold in turn. normal: basis of f^z.
BasisCandidate judge(const std::vector<PointEvidence>& points, const CurveBasis& normal,
                     const CurveBasis& basis, KnotPlacement placement);

/// Whether a candidate predicts held-out rows within the tolerance, and no three neighbouring
/// abscissae are off together by more than one and a half of it.
bool meets(const BasisCandidate& candidate, double tolerance);

/// Whether a candidate's local error exceeds the best one's, and the tolerance, by less than half:
/// the rest is noise, of which more pieces leave as much.
bool is_as_good_locally(const BasisCandidate& candidate, const BasisCandidate& best,
                        double tolerance);

/// Whether a candidate is as good locally and its held-out errors exceed the best one's by no more
/// than the tolerance or, row by row, their scatter: what both leave is noise.
bool is_as_good(const BasisCandidate& candidate, const BasisCandidate& best, double tolerance);

}  // namespace palpate::fit
