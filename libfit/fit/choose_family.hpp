#pragma once

#include "libfit/fit/fit_point.hpp"

namespace palpate::fit {

/// Which family describes the body, judged by rows that the curves did not see: every other row of
/// each experiment is held out in turn, its path still replayed. `leaning` is taken when separable
/// curves miss the tolerance and its held-out error is lower by a tenth ("model only what a scene
/// needs"). Work: two fits in each family of at most 24 points, evenly taken.
/// bases: with the lean's basis in both units.
FamilyReport choose_family(const BodyData& body, const std::vector<PointRows>& rows,
                           const BodyBases& bases, const FitOptions& options);

}  // namespace palpate::fit
