#pragma once

#include <functional>

#include "libfit/fit/point/fit_point.hpp"

namespace palpate::fit {

/// What the points of a body are fitted with when it is coupled or not; bases with the lean's in
/// both units.
struct FamilySetting {
  std::vector<PointRows> rows;
  BodyBases bases;
};

/// Relative error of rows that the curves did not see: every other row of each experiment is held
/// out in turn, its path still replayed. At most 24 points, evenly taken.
FamilyEvidence judge_family(const BodyData& body, const FamilySetting& setting, CurveFamily family,
                            const FitOptions& options);

/// Which family describes the body, by judge_family(). From separable on, a family is taken when
/// those before it miss the tolerance, its p95 is lower by a tenth and its median no higher ("model
/// only what a scene needs"); last anisotropic, then the best of the others with an anisotropy.
/// setting: of a body that is coupled or not, asked for when it is tried.
FamilyReport choose_family(const BodyData& body,
                           const std::function<const FamilySetting&(bool is_coupled)>& setting,
                           const FitOptions& options);

}  // namespace palpate::fit
