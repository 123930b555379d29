#pragma once

#include <cstddef>
#include <vector>

#include "libfit/core/samples.hpp"

namespace palpate::tools {

/// Points that are dragged first, and solved on two meshes: those from which the rings of a body
/// and the error of presses on one mesh are known. Four on the phantom miss how rings change above
/// its tumour (p95 back and forth 8.6 % in place of 3).
inline constexpr std::size_t kFirstDrags = 6;

/// Chooses by presses of every first point; numbers of points, ascending. By their force points
/// fall into kFirstDrags groups; of each the one is dragged whose force leans least off the normal,
/// of the last the one of greatest force. The constants of rings go with the force; beside a fold
/// or a ridge a drag tells of it and not of the rings. A point whose press did not come to its end
/// is taken where its group has no other.
std::vector<std::size_t> points_to_drag(const Samples& presses);

/// Upright points that are dragged last: those of whose force no upright dragged one tells, a
/// further one each time, until each is nearer than a factor kFarForce to one, and one for
/// kPointsPerDrag points at most: a drag costs some ten presses. Twelve first points do not meet a
/// tumour's top. Where all that are dragged lean there are none.
inline constexpr std::size_t kPointsPerDrag = 40;
inline constexpr double kFarForce = 1.1;
std::vector<std::size_t> points_beyond_drags(const Samples& presses,
                                             std::vector<std::size_t> dragged);

}  // namespace palpate::tools
