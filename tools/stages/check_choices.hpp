#pragma once

#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// Refuses what a run of the scene would refuse later: check_simulated(), and pairs of tools or a
/// [tool] that the simulator or the engine does not know. Throws Error with a remedy.
void check_choices(const Scene& scene);

}  // namespace palpate::tools
