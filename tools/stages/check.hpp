#pragma once

#include "libfit/core/body.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// What a simulation needs of a scene: a [material], and a probe that its table knows and accepts.
/// Throws Error with a remedy.
void check_choices(const Scene& scene);

/// What only the body can tell: a probe larger than it, a depth larger than it is thick. Throws
/// Error with the scene's key and a remedy.
void check_experiments(const Scene& scene, const Body& body);

}  // namespace palpate::tools
