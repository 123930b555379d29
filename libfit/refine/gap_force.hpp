#pragma once

#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/core/probe.hpp"
#include "libfit/refine/edge_paths.hpp"

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

/// Logarithms of the force with which an elastic half-space of modulus 1 would answer the tool if
/// its surface had the shape that the body's has around a place [log m^2]. A ridge touches little
/// of a tool and a hollow much; the half-space knows that of each place before anything is pressed.
/// (M12d), first order in the surface's heights: the mean height of circles about the press, as a
/// tool's profile, in Sneddon's solution (1965, doi:10.1016/0020-7225(65)90019-4) as a sum over
/// springs (Popov and Hess 2015, doi:10.1007/978-3-662-53876-0). Heights are along the press, of
/// what hangs together with the place and faces the tool; an open surface is taken to go on past
/// its border. outward_normal: V x 3, unit. is_wanted: #V. seeds: #P, where points lie on the
/// surface. tool: of a width above 0. O(V times the triangles under the tool).
LogForces gap_forces(const FittedCurves& curves, const Surface& fine, const Points& outward_normal,
                     const std::vector<char>& is_wanted, const std::vector<EdgePathSeeds>& seeds,
                     const Indenter& tool);

}  // namespace palpate
