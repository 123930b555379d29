#pragma once

#include <array>
#include <string>

#include "libfit/fit/point/body_bases.hpp"
#include "libfit/fit/rows/curve_rows.hpp"

namespace palpate::fit {

/// The curves of one point on their way: increments in units of the point's force, on bases in
/// units of the body's length.
struct PointCurves {
  std::array<Eigen::VectorXd, kCurveKinds> increments;
  std::array<Eigen::VectorXd, kCurveKinds> lower;  ///< bounds; > 0 for the lateral curve
  std::array<bool, kCurveKinds> is_identified{false, false, false};  ///< rows speak of it
  std::array<WeakPrior, kCurveKinds>
      weak_prior;  ///< what decides where rows are silent, of identified ones
  /// What is fitted of the family's parts after the curve kinds, one after the other
  /// (part_controls), on the same units.
  Eigen::VectorXd more;
  /// What they are likely to be, with which deviation, and within which bounds.
  Eigen::VectorXd more_expected, more_deviation, more_lower, more_upper;
  double log_force = 0;   ///< of a press to the end of its basis [ln N], where rings ask for it
  double more_noise = 0;  ///< of the rows' force, to which the deviations compare; 0: unknown
  std::vector<NuisanceValues>
      nuisance;  ///< of each experiment, where a part of it is unknown; else 0
  /// Set by solve_point: robust deviation of the weighted residuals' sizes, the rows' noise over
  /// their force, and the weights of each experiment's rows.
  double scale = 0, noise = 0;
  std::vector<std::vector<double>> weight;
  double friction = 0;  ///< L / f^z where rows do not say otherwise
  std::string problem;  ///< no curve can be made; empty otherwise
  std::string message;  ///< sentences on what is missing and what stands in for it
};

/// Bounded linear fits to a point's rows as curve_rows classifies them, and the documented
/// stand-ins for curves no row speaks of. Rings begin as bodies' are and with the side force of
/// presses, every other part
/// at 0.
PointCurves start_values(const PointData& point, const CurveRows& rows, const BodyBases& bases,
                         const FitOptions& options);

}  // namespace palpate::fit
