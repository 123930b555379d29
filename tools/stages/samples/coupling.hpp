#pragma once

#include "libfit/core/curves.hpp"
#include "libfit/core/samples.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// Identifies how contacts feel each other (M62) from the pairs and the paths of [tool] among the
/// samples, into the model, and says how well; nothing where there are none.
void add_coupling(Model& model, const Scene& scene, const Samples& samples);

}  // namespace palpate::tools
