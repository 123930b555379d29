#pragma once

#include "libfit/core/samples.hpp"
#include "libfit/validation/paths.hpp"

namespace palpate::validation {

/// What an asset is compared with.
struct Reference {
  HeldOut held_out;
  Samples paths;  ///< simulated along held_out.paths
  Samples own;    ///< presses and drags at the held-out points themselves; empty unless wanted
};

}  // namespace palpate::validation
