#pragma once

#include <cstdint>
#include <vector>

#include "libfit/core/samples.hpp"

namespace palpate {

/// Puts deflection and force of presses, holds and cycles onto the normal of their place: a press
/// tells force over depth, and what an encoder's noise, a rig that leans or a frame that drifted
/// add sideways is neither motion along the surface nor friction. A press that goes straight keeps
/// every bit, its side force too (simulated ones do). A press stays as it is also where it was
/// moved sideways on purpose: by more than a third of its depth, and with a force along that motion
/// beyond what the rows scatter by. Returns the experiments that stay so, ascending.
std::vector<std::int32_t> straighten_presses(Samples& samples);

/// Whether straighten_presses() would change a row.
bool has_crooked_press(const Samples& samples);

}  // namespace palpate
