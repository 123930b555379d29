#pragma once

#include <filesystem>

#include "libfit/core/body.hpp"
#include "libfit/core/curves.hpp"
#include "libfit/core/samples.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// Whether some material of the scene softens where it was strained.
bool softens(const Scene& scene);

/// Presses in cycles at [experiments] cycles of the body's test points, spread evenly over their
/// list: what the fit learns from how the body softens. Written to `output` with the fingerprint.
/// Throws Interrupted when the user stopped it: nothing is written then.
Samples simulate_cycles(const Scene& scene, const Body& body, int jobs,
                        const std::filesystem::path& output, const std::string& fingerprint);

/// Identifies how the body softens, into curves.curves.damage; said on stderr. may_dent: the cycles
/// were recorded, so a dent may stay.
void add_damage(FittedCurves& curves, const Samples& cycles, bool may_dent = false);

}  // namespace palpate::tools
