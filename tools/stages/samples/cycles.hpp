#pragma once

#include <filesystem>

#include "libfit/core/body.hpp"
#include "libfit/core/curves.hpp"
#include "libfit/core/samples.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// Whether some material of the scene softens where it was strained.
bool softens(const Scene& scene);

/// Identifies how the body softens, into curves.curves.damage; said on stderr. may_dent: the cycles
/// were recorded, so a dent may stay.
void add_damage(FittedCurves& curves, const Samples& cycles, bool may_dent);

}  // namespace palpate::tools
