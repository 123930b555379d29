#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libfit/core/row_index.hpp"
#include "libfit/fit/point/fit_point.hpp"

namespace palpate::fit {

/// What each point's curves depend on besides bases and family, without its rows: its place, the
/// hash of its rows, and the options that a point's own fit reads. 16 hex digits a point; equal
/// means the curves need no refit. points: test points, rows need not be there.
std::vector<std::string> point_hashes(const Samples& points, const RowIndex& index,
                                      const FitOptions& options);
/// Adds what a point's rows do not say: what is unknown of its sensors, and the body's force error
/// where its own rows state none.
void add_borrowed(const BodyData& body, std::vector<std::string>& hashes);

/// Points of an earlier fit with all that a report asks of them.
class EarlierPoints {
 public:
  /// Of nothing, or of curves that were stored without scores: none is found. The curves must
  /// outlive it.
  explicit EarlierPoints(const FittedCurves* earlier);
  /// The row of each point's hash, or -1.
  std::vector<Eigen::Index> rows_of(const std::vector<std::string>& hashes) const;
  /// That point's result as the earlier fit left it, before it was smoothed; scores are those
  /// after. first_experiment: id of the point's first row now. experiments: of the point, where its
  /// sensors are asked for.
  PointResult keep(Eigen::Index row, std::int32_t first_experiment, std::size_t experiments) const;
  /// Deepest row of the points kept [m].
  double depth_m(const std::vector<Eigen::Index>& kept) const;
  /// Whether the rows of the points kept and those of `body` state force errors all, or none does:
  /// else a point's weights depend on rows that are not there.
  bool are_errors_alike(const std::vector<Eigen::Index>& kept, const BodyData& body) const;

 private:
  const FittedCurves* earlier_ = nullptr;
  std::vector<std::size_t> first_error_;  // of each row's relative errors; one more at the end
};

/// Scores as curves.h5 keeps them.
FitScores collect_scores(const RowIndex& index, const std::vector<PointResult>& results);

}  // namespace palpate::fit
