#pragma once

#include "libfit/core/curves.hpp"
#include "libfit/core/samples.hpp"

namespace palpate::tools {

/// Identifies how the body's surface moves from samples that tell it, and puts it into the model
/// that was made of their curves; says what was chosen. Leaves the model as it is where the samples
/// tell nothing of its surface.
void add_shape(Model& model, const Samples& samples);

}  // namespace palpate::tools
