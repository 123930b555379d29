#pragma once

#include "libfit/fit/point/replay.hpp"

namespace palpate::fit {

/// Curves on the quadric around a place (docs/method.md, M11), which answer experiments there.
/// Not owned: what it points to must outlive it.
struct LocalCurves {
  const Bases* bases;
  runtime::ControlPointers<double> controls;
  runtime::Quadric quadric;
};
/// A row of `curves`, whose bases these are, at a point of the samples.
LocalCurves curves_at(const Bases& bases, const CurveSet& curves, Eigen::Index row,
                      const Samples& samples, Eigen::Index point);

/// The point of `curves` at a place, within 1e-6 of their extent, if it has curves; else -1.
Eigen::Index point_at(const FittedCurves& curves, const Vec3& place);

/// Answers of curves to the rows of one experiment.
struct LocalAnswer {
  Points force;  ///< ON THE BODY, #rows x 3
  int slipped_rows = 0;
};
/// Forces of a tool that follows `path`, #rows x 3, deflections from the place, in order: the
/// law of section 4 as the fit sees it. time_s: of each row since first touch, or null in slow
/// motion. sensor: nuisance values, added to its reading (M18). Units are those of the curves.
LocalAnswer local_answer(const LocalCurves& curves, const Points& path,
                         const double* time_s = nullptr, const NuisanceValues& sensor = {});
/// The same of rows of samples, in their time where they have one [m, N].
LocalAnswer local_answer(const LocalCurves& curves, const Samples& samples,
                         const std::vector<Eigen::Index>& rows, const NuisanceValues& sensor = {});

}  // namespace palpate::fit
