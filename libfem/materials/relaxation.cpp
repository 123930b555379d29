#include "libfem/materials/relaxation.hpp"

namespace palpate::fem {

Refusal refuse_relaxation(const Relaxation& relaxation) {
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
  return {};
}

}  // namespace palpate::fem
