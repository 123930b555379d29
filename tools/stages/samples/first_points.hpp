#pragma once

#include <cstddef>
#include <vector>

#include "libfit/core/samples.hpp"

namespace palpate::tools {

/// Points that are dragged first, and points that are pressed on two meshes besides: those from
/// which the rings of a body and the error of presses on one mesh are known.
inline constexpr std::size_t kFirstDrags = 4, kFirstCompared = 2;

/// Numbers of points, ascending. on_two_meshes: with the dragged ones.
struct FirstPoints {
  std::vector<std::size_t> dragged, on_two_meshes;
};

/// Chooses by presses of every first point. Dragged are points of the half whose force leans least
/// off the normal, from the least to the greatest force there: beside a fold or a ridge a drag
/// tells of it and not of the rings, whose constants go with the force. Those that are compared
/// besides have the least and the greatest force of the others. Points whose press did not come to
/// its end come last.
FirstPoints choose_first_points(const Samples& presses);

}  // namespace palpate::tools
