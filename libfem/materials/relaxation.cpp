#include "libfem/materials/relaxation.hpp"

namespace palpate::fem {

Refusal refuse_relaxation(const LawRow& law, const MaterialParameters& complete) {
  const Relaxation& relaxation = complete.relaxation;
  const auto refused = [](const std::string& text) { return Refusal{"relaxation", text}; };
  if (relaxation.branches() == 0) return {};
  if (relaxation.branches() > runtime::kMaxBranches)
    return refused("must have " + std::to_string(runtime::kMaxBranches) + " branches or fewer");
  for (Eigen::Index k = 0; k < relaxation.branches(); ++k) {
    if (!(relaxation.share[k] > 0 && relaxation.share[k] <= runtime::kMaxShare))
      return refused("must have shares above 0 and up to " + short_number(runtime::kMaxShare));
    if (!(relaxation.time_s[k] >= runtime::kMinRelaxation_s &&
          relaxation.time_s[k] <= runtime::kMaxRelaxation_s))
      return refused("must have times from " + short_number(runtime::kMinRelaxation_s) + " to " +
                     short_number(runtime::kMaxRelaxation_s) + " s");
    if (k > 0 && !(relaxation.time_s[k] > relaxation.time_s[k - 1]))
      return refused("must have times that rise");
  }
  if (!law.splits_volume)
    return refused("must be left out with law " + std::string(law.name) +
                   ", which does not split volume from shape, and it is the shape that relaxes");
  // The bulk modulus that W - U has follows it; of some laws it is negative.
  const LawConstants constants = law.constants(complete.values);
  double U, U1, U2;
  law.volumetric(constants, 0, U, U1, U2);
  const double shape_Pa = law.small_strain(constants).bulk_Pa() - U2;
  if (!(U2 + instantaneous_stiffness(relaxation) * shape_Pa > 0))
    return refused("must leave a bulk modulus at first: its shares are too large for this law");
  return {};
}

}  // namespace palpate::fem
