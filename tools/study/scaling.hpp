#pragma once

#include <string>

#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// All that the samples of a scene depend on, moduli by their ratios.
std::string unscaled(Scene scene);

/// The factor between the forces of two scenes whose samples differ by that alone, 0 where they
/// differ otherwise. All laws are linear in their moduli (an energy density has no other source of
/// its unit), and friction, contact and geometry know no unit of force. Placed points do: what they
/// predict is compared with a force that is just noticeable.
double force_factor(const Scene& source, const Scene& scene);

}  // namespace palpate::tools
