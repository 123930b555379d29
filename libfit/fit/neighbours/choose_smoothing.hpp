#pragma once

#include "libfit/fit/neighbours/graph_quadratic.hpp"
#include "libfit/fit/options.hpp"
#include "libfit/fit/report.hpp"
#include "libfit/fit/rows/curve_rows.hpp"

namespace palpate::fit {

/// Curves of one kind at the points that take part in smoothing, without dimension: increments over
/// the body's typical increment, n each.
struct SmoothingData {
  CurveBasis basis;                         ///< over the body's length
  Controls estimate;                        ///< P x n
  std::vector<Eigen::MatrixXd> covariance;  ///< P of n x n
  std::vector<PointEdge> edges;             ///< between rows
  std::vector<std::vector<CurveRow>> rows;  ///< P, weights of mean square 1
  Controls unit;                            ///< P x n, force of one increment over that of the rows
};

/// The least strength, 0 included, whose error of held-out rows is within a standard error of the
/// least error: five folds over abscissae, each held out at all points at once, so that no
/// neighbour has seen what is predicted, and what neighbours get wrong alike is no gain. 0, too,
/// where less than a tenth of the curves' own error would be gained or, by two standard errors,
/// more than all of it: then rows are off by what no curve of the family says, and neighbours make
/// up for it in rows not seen alone. Fills strength, evidence, gain and reason of the report.
/// Source: Hastie, Tibshirani and Friedman, The Elements of Statistical Learning (2009), 7.10.
void choose_smoothing(const SmoothingData& data, FitLoss loss, SmoothingReport& report);

}  // namespace palpate::fit
