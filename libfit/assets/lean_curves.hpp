#pragma once

#include <vector>

#include "libfit/core/curves.hpp"

namespace palpate {

/// Control curves over the lean of a tool (docs/method.md, M59): upright, then of each tilt three
/// directions. V vertices.
struct LeanCurves {
  std::vector<double> sine;  ///< of the tilts beside upright, rising; none: no curves
  struct NodeCurves {
    Controls normal, side_square, side_cube;  ///< V rows, as the parts of rings
  };
  std::vector<NodeCurves> node;  ///< 1 + 3 tilts
};

}  // namespace palpate
