#pragma once

#include "libfit/core/body.hpp"
#include "tools/scene.hpp"

namespace palpate::tools {

/// Names that only the libraries' tables know: material laws, probe shapes. Throws Error naming the
/// known ones.
void check_choices(const Scene& scene);

/// What only the body can tell: a probe larger than it, a depth larger than it is thick. Throws
/// Error with the scene's key and a remedy.
void check_experiments(const Scene& scene, const Body& body);

}  // namespace palpate::tools
