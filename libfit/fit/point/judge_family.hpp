#pragma once

#include "libfit/fit/point/fit_point.hpp"

namespace palpate::fit {

/// Relative error of rows that the curves did not see: every other row of each experiment is held
/// out in turn, its path still replayed. At most 24 points, evenly taken.
FamilyEvidence judge_family(const BodyData& body, const std::vector<CurveRows>& rows,
                            BodyBases bases, CurveFamily family, const FitOptions& options);

/// Whether the second is worth taking instead of the first: its p95 is lower by a tenth and its
/// median no higher.
bool is_worth_it(const FamilyEvidence& first, const FamilyEvidence& second);
/// The same of a body's computed sway, which adds no unknown: the median may tell as well, where
/// p95 is not worse by a tenth; not where it leaves a tenth of the rows unjudged. Of a few dragged
/// points p95 is that of the one beside a fold.
bool is_worth_its_sway(const FamilyEvidence& without, const FamilyEvidence& with);
/// Family, median and p95 in words.
std::string in_words(const FamilyEvidence& evidence);

}  // namespace palpate::fit
