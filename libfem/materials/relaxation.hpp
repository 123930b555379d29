#pragma once

#include "libfem/materials/materials.hpp"

namespace palpate::fem {

/// Shear modulus at first over that of slow motion: 1 + sum_k g_k.
inline double instantaneous_stiffness(const Relaxation& relaxation) {
  return 1 + relaxation.share.sum();
}

/// Why a material cannot relax as it says, if so.
Refusal refuse_relaxation(const Relaxation& relaxation);
inline constexpr const char* kRelaxationRemedy =
    "Give relaxation = [[g, \"tau\"], ...]: shares of the long-term shear modulus and times.";

}  // namespace palpate::fem
