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

/// A last drag costs 2.5 CPU seconds on the phantom and 8 on the dragon: one for so many points,
/// and no more than these.
inline constexpr std::size_t kPointsPerDrag = 30, kLastDrags = 3;
/// Forces further apart than this factor tell nothing of each other's rings.
inline constexpr double kFarForce = 1.1;

/// Points that are dragged last, numbers of points of presses, the furthest first: upright ones
/// whose force no upright one of `dragged` tells. Twelve first points do not meet a tumour's top.
/// None where all of `dragged` lean.
std::vector<std::size_t> points_beyond_drags(const Samples& presses,
                                             const std::vector<std::size_t>& dragged);

}  // namespace palpate::tools
