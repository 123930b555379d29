#pragma once

#include "libfit/fit/point/fit_point.hpp"

namespace palpate::fit {

/// Relative error of rows that curves of a family did not see.
struct FamilyEvidence {
  double median_error = 0, p95_error = 0;
  std::ptrdiff_t rows = 0;  ///< held out, whose points had curves
};

/// Holds every other row of each experiment out in turn, its path still replayed. At most 24
/// points, evenly taken.
FamilyEvidence judge_family(const BodyData& body, const std::vector<CurveRows>& rows,
                            const BodyBases& bases, const FitOptions& options);

/// Whether a body's computed sway, which adds no unknown, is worth taking off: p95 is lower by a
/// tenth and the median no higher, or the median is lower by a tenth and p95 not worse by one; not
/// where it leaves a tenth of the rows unjudged. Of a few dragged points p95 is that of the one
/// beside a fold.
bool is_worth_its_sway(const FamilyEvidence& without, const FamilyEvidence& with);

}  // namespace palpate::fit
