#pragma once

#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/refine/points_on_surface.hpp"

// Interpolations between test points, and the choice among them.

namespace palpate {

/// Curves between test points are compared at so many even depths, the last the end of the range.
inline constexpr int kComparedDepths = 4;

/// Logarithms of forces at compared depths, but for a constant, over which forces are blended
/// (M12g, M12f). Empty where forces are blended as they are.
struct LogForces {
  Controls at_point;     ///< P x kComparedDepths; 0 where a point has no seeds
  Controls at_vertex;    ///< V x kComparedDepths; 0 where not wanted
  bool smooths = false;  ///< vertices at test points, too (M12f)
  bool is_known() const { return at_point.size() > 0; }
};

/// Power of (M12g) with which forces follow the gap's force. A ridge is softer than a half-space
/// with its gap, and simulation blunts both. With 0, 3/4 and 1 a prototype on the samples of 80
/// points predicted points left out to (mean, %) 10.4, 5.9, 6.4 on a liver with ridges of the
/// tool's size, 3.4, 1.4, 1.6 on a smoother one, 10.8, 5.9, 7.7 on a dragon.
inline constexpr double kGapShare = 0.75;

/// Logarithms of forces (1 x kComparedDepths) at the Greville abscissae of a curve's controls.
Eigen::RowVectorXd at_controls(const CurveBasis& basis, const Eigen::RowVectorXd& log_force);

/// Predictions of presses from the gap between the tool and the surface around a place.
struct GapForces {
  LogForces force;
  /// V: k of (M83) by the same gap (M83a) [1]. A wider ball touches more of a hollow than of an
  /// even surface, and less of a ridge. 0 where not wanted, and where the tool is no ball.
  Eigen::VectorXd radius_effect;
};

/// Logarithms of the force with which an elastic half-space of modulus 1 would answer the tool if
/// its surface had the shape that the body's has around a place [log m^2]. A ridge touches little
/// of a tool and a hollow much; the half-space knows that of each place before anything is pressed.
/// (M12d), first order in the surface's heights: the mean height of circles about the press, as a
/// tool's profile, in Sneddon's solution (1965, doi:10.1016/0020-7225(65)90019-4) as a sum over
/// springs (Popov and Hess 2015, doi:10.1007/978-3-662-53876-0). Heights are along the press, of
/// what hangs together with the place and faces the tool; an open surface is taken to go on past
/// its border. outward_normal: V x 3, unit. is_wanted: #V. seeds: #P, where points lie on the
/// surface. tool: of a width above 0. O(V times the triangles under the tool).
GapForces gap_forces(const FittedCurves& curves, const Surface& fine, const Points& outward_normal,
                     const std::vector<char>& is_wanted, const std::vector<EdgePathSeeds>& seeds,
                     const Indenter& tool);

/// Slope of the normal curve along the surface from each test point, by the side force of its
/// presses (B4a): P x 3 n, x, y, z of control value after control value [N/m]. No columns where the
/// family knows no side force.
Controls slopes_of(const FittedCurves& curves);

/// Makes control values rise: each is at least the one before.
void clamp_rising(Eigen::Ref<Eigen::RowVectorXd> control);

/// Numbers that were measured, with errors, at points of a surface, at other places of it (M12f):
/// ordinary kriging of each, by the same covariances. Covariances fall with the distance, and with
/// the angle between normals, so that the other side of a thin part is far. Of 32 of them (range,
/// share of the angle, nugget) each counts with its restricted likelihood (Patterson and Thompson
/// 1971; of several numbers the geometric mean), so that few points do not decide by chance (of
/// more than 300 points an even share judges). O(P^3); deterministic.
class Kriging {
 public:
  /// position, normal: P x 3 [m], unit; no normals: distances alone count, there and below.
  /// value: P x n. Three points or more.
  Kriging(const Points& position, const Points& normal, const Eigen::MatrixXd& value);

  /// At places Q x 3 with normals Q x 3; at a point itself without what its nugget smooths. Q x n.
  Eigen::MatrixXd at(const Points& position, const Points& normal) const;

  /// P x n: at each point from the others (Dubrule 1983).
  const Eigen::MatrixXd& left_out() const { return left_out_; }

 private:
  struct Covariance {
    double range_m, turn_m, nugget;
  };
  struct KeptCovariance {
    Covariance covariance;
    double share;
    Eigen::RowVectorXd mean;  // n
    Eigen::MatrixXd weight;   // P x n, of the covariances with the points
  };
  struct FittedCovariance;
  static Eigen::MatrixXd between(const Covariance& covariance, const Points& a,
                                 const Points& a_normal, const Points& b, const Points& b_normal);

  static FittedCovariance fitted(const Covariance& covariance, const Points& position,
                                 const Points& normal, const Eigen::MatrixXd& value);

  Points position_, normal_;
  std::vector<KeptCovariance> kept_;
  Eigen::MatrixXd left_out_;
};

/// The interpolation between test points that is used, and the evidence: mean error of the normal
/// force at test points left out, relative: as chosen, without anything, with the best share of
/// slopes, over the gap's force, over the trend of tilt as well, kriged. Errors are 0 where no
/// point could be left out.
struct InterpolationChoice {
  double slope_share = 0;    ///< of the slopes of test points (B4), 0 to 1/2
  bool follows_gap = false;  ///< the gap's force (M12g); refine() then counts no slopes
  bool is_kriged = false;    ///< forces are those of (M12f); then nothing else is made use of
  /// Inward normals of vertices are kriged from the points' own: the surface's do not foretell
  /// those of points left out better by more than chance.
  bool kriges_normals = false;
  int points = 0;  ///< that could be left out
  double error = 0, plain_error = 0, slope_error = 0, gap_error = 0, kriged_error = 0;
  double surface_normal_rad = 0, kriged_normal_rad = 0;  ///< mean angles to points' own normals
  std::vector<std::int32_t> left_out;  ///< the points that were left out, one by one
  Controls left_out_normal;  ///< their normal curves, rows of controls, as the model interpolates
};

/// Logarithms of the normal force of each test point, P x kComparedDepths. What the error statement
/// does not count (relative_floor_N) counts as its floor.
Controls log_forces(const FittedCurves& curves, const std::vector<char>& is_usable);

/// Each measured point kriged from the others: log_forces (P x kComparedDepths) and the inward
/// normal (P x 3, not unit). Empty: not measured, or too few.
struct MeasuredPoints {
  Controls force{0, kComparedDepths};
  Points normal{0, 3};
  Points surface_normal{0, 3};  ///< the surface's there
  bool is_there() const { return force.size() > 0; }
};

/// Leaves out one test point at a time and predicts it from its neighbours, at four depths. Slopes
/// are chosen where they take off a twentieth of the error, and need four points that neighbours
/// surround. The gap's force is made use of unless slopes err less, or its median error is above
/// that of area by more than chance, a factor of 1 + 1 / sqrt(points). Measured points, whose
/// surface is less sure, are kriged, and their normals, unless that errs more by more than chance.
/// They are left out at the rim, too, where the nearest line between two others answers. is_usable:
/// points that count; the others are neither left out nor predict. slopes: slopes_of(curves).
InterpolationChoice choose_interpolation(const FittedCurves& curves, const Triangles& triangles,
                                         const std::vector<char>& is_usable, const Controls& slopes,
                                         const LogForces& gap, const MeasuredPoints& measured = {});

}  // namespace palpate
