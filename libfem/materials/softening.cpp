#include "libfem/materials/softening.hpp"

namespace palpate::fem {

Refusal refuse_softening(const MaterialParameters& material) {
  const Softening& softening = material.softening;
  const auto refused = [](const std::string& text) { return Refusal{"softening", text}; };
  if (!softening.is_any()) return {};
  if (!(softening.r >= 1 && softening.r <= kMaxSoftening))
    return refused("must have r from 1 to " + short_number(kMaxSoftening));
  if (!(softening.scale_Pa >= 0 && softening.beta >= 0 && softening.beta <= kMaxSoftening &&
        softening.scale_Pa + softening.beta > 0))
    return refused("must have m and beta from 0, and not both 0");
  if (material.relaxation.branches() > 0)
    return refused("must be left out of a material that relaxes");
  return {};
}

}  // namespace palpate::fem
