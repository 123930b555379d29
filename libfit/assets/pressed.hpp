#pragma once

#include <string>
#include <vector>

#include "libfit/assets/stiffness_map.hpp"

namespace palpate {

/// How the surface lies under a press, for a morph target.
struct PressedShape {
  std::string name;       ///< "press at vertex 12, 10.0 mm, stiffest 1"
  Eigen::Index vertex;    ///< where the tool presses, along the inward normal
  Points displacement_m;  ///< V x 3
};

/// Presses to the deepest of the shape response at the two stiffest and the two softest test points
/// of a map, as the engine shows them. None where the model does not say how its surface moves.
std::vector<PressedShape> pressed_shapes(const Model& model, const StiffnessMap& map);

}  // namespace palpate
