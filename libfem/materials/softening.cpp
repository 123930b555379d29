#include "libfem/materials/softening.hpp"

namespace palpate::fem {

Refusal refuse_softening(const LawRow& law, const MaterialParameters& complete) {
  const Softening& softening = complete.softening;
  const auto refused = [](const std::string& text) { return Refusal{"softening", text}; };
  if (!softening.is_any()) return {};
  if (!(softening.r >= 1 && softening.r <= kMaxSoftening))
    return refused("must have r from 1 to " + short_number(kMaxSoftening));
  if (!(softening.scale_Pa >= 0 && softening.beta >= 0 && softening.beta <= kMaxSoftening &&
        softening.scale_Pa + softening.beta > 0))
    return refused("must have m and beta from 0, and not both 0");
  if (!law.splits_volume)
    return refused("must be left out with law " + std::string(law.name) +
                   ", which does not split volume from shape, and it is the shape that softens");
  if (complete.relaxation.branches() > 0)
    return refused("must be left out of a material that relaxes");
  return {};
}

}  // namespace palpate::fem
