#pragma once

#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/refine/gap_force.hpp"

namespace palpate {

/// What interpolation between test points makes use of, and the evidence: mean error of the normal
/// force at test points left out, relative: as chosen, without anything, with the best share of
/// slopes, over the gap's force, over the trend of tilt as well, kriged. Errors are 0 where no
/// point could be left out.
struct InterpolationChoice {
  double slope_share = 0;    ///< of the slopes of test points (B4), 0 to 1/2
  bool follows_gap = false;  ///< the gap's force (M12g); refine() then counts no slopes
  bool is_kriged = false;    ///< forces are those of (M12f); then nothing else is made use of
  /// Inward normals of vertices are kriged from the points' own: the surface's foretell those of
  /// points left out worse.
  bool kriges_normals = false;
  int points = 0;  ///< that could be left out
  double error = 0, plain_error = 0, slope_error = 0, gap_error = 0, kriged_error = 0;
  double surface_normal_rad = 0, kriged_normal_rad = 0;  ///< mean angles to points' own normals
  std::vector<std::int32_t> left_out;  ///< the points that were left out, one by one
  Controls left_out_normal;  ///< their normal curves, rows of controls, as the model interpolates
};

/// Logarithm of the normal force of each test point, mean over four depths; 0 where there is none,
/// and is_usable then 0.
Eigen::VectorXd log_forces(const FittedCurves& curves, std::vector<char>& is_usable);

/// What kriging makes of each measured point from the others: log_forces (P) and the inward normal
/// (P x 3, not unit). Empty: not measured, or too few.
struct MeasuredPoints {
  Eigen::VectorXd force;
  Points normal{0, 3};
  Points surface_normal{0, 3};  ///< the surface's there
  bool is_there() const { return force.size() > 0; }
};

/// Leaves out one test point at a time and predicts it from its neighbours, at four depths. Slopes
/// and kriging are chosen where they take off a twentieth of the error. The gap's force is made use
/// of unless slopes err less, or its median error is above that of area by more than chance, a
/// factor of 1 + 1 / sqrt(points). Measured points, whose surface is less sure, are kriged. Slopes
/// need four points that neighbours surround, kriging six. Measured points are left out at the rim,
/// too, where the nearest line between two others answers. is_usable: points that count; the others
/// are neither left out nor predict. slopes: slopes_of(curves).
InterpolationChoice choose_interpolation(const FittedCurves& curves, const Triangles& triangles,
                                         const std::vector<char>& is_usable, const Controls& slopes,
                                         const LogForces& gap, const MeasuredPoints& measured = {});

}  // namespace palpate
