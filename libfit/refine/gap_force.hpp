#pragma once

#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/core/probe.hpp"
#include "libfit/refine/edge_paths.hpp"

namespace palpate {

/// Curves between test points are compared at so many even depths, the last the end of the range.
inline constexpr int kComparedDepths = 4;

/// Logarithms of the force with which an elastic half-space of modulus 1 would answer the tool if
/// its surface had the shape that the body's has around a place [log m^2], at compared depths. A
/// ridge touches little of a tool and a hollow much; the half-space knows that of each place before
/// anything is pressed there (M12d).
struct GapForces {
  Controls at_point;   ///< P x kComparedDepths; 0 where a point has no seeds
  Controls at_vertex;  ///< V x kComparedDepths; 0 where not wanted
  bool is_known() const { return at_point.size() > 0; }
};

/// (M12d), first order in the surface's heights: the mean height of circles about the press, as a
/// tool's profile, in Sneddon's solution (1965, doi:10.1016/0020-7225(65)90019-4) as a sum over
/// springs (Popov and Hess 2015, doi:10.1007/978-3-662-53876-0). Heights are along the press, of
/// what hangs together with the place and faces the tool; an open surface is taken to go on past
/// its border. outward_normal: V x 3, unit. is_wanted: #V. seeds: #P, where points lie on the
/// surface. tool: of a width above 0. O(V times the triangles under the tool).
GapForces gap_forces(const FittedCurves& curves, const Surface& fine, const Points& outward_normal,
                     const std::vector<char>& is_wanted, const std::vector<EdgePathSeeds>& seeds,
                     const Indenter& tool);

}  // namespace palpate
