#pragma once

#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// Refuses numbers that were meant in another unit: a bare `radius = 8` is 8 m. Throws Error,
/// naming key, size of the body and likely unit, where a length of probe, experiments or a region
/// is ten times the body or more, or a region lies beside the body, and in mm, cm or um would not.
/// Reads the body's mesh only where a length of the scene is long for any body (0.3 m).
void refuse_misread_lengths(const Scene& scene);

}  // namespace palpate::tools
