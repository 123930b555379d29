#pragma once

#include <string>
#include <vector>

#include "libfit/core/body.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// What a scene says that no tissue, tool or body is like, one sentence each with the likely slip:
/// a modulus read in the wrong unit, a probe or a body of the wrong size, too much friction.
std::vector<std::string> implausible(const Scene& scene, const Body& body);

/// The same of the body's shape alone, without its material: an unlikely size, separate parts, a
/// tetmesh that is cut where its nodes are doubled.
std::vector<std::string> doubts_of_shape(const Scene& scene, const Body& body);

/// Where an inclusion lies. inside: share of its volume in the body; NaN for half-spaces.
struct InclusionPlace {
  double volume_m3 = 0;  ///< inside the body
  double inside = 0;
  double depth_m = 0;     ///< least distance between its border and the surface; 0: cut by it
  Eigen::Index tets = 0;  ///< of the base mesh, by their centres
};

/// One for each of the scene's inclusions, from some 20,000 samples of its box. Throws Error where
/// none of an inclusion is inside the body.
std::vector<InclusionPlace> place_inclusions(const Scene& scene, const Body& body);

/// "194 x 154 x 156 mm, 1.48 l": so that a wrong unit is seen. Volume left out when 0.
std::string size_in_words(const Vec3& extent_m, double volume_m3);

/// "x -1.0 to 20.0, y 0.0 to 3.0, z 0.0 to 30.0 mm": where nodes lie.
std::string span_in_words(const Points& nodes);

/// Says what is implausible and where inclusions lie on stderr.
void say_plausibility(const Scene& scene, const Body& body);

}  // namespace palpate::tools
