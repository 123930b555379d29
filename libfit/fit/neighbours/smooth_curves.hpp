#pragma once

#include "libfit/core/curves.hpp"
#include "libfit/fit/point/fit_point.hpp"

namespace palpate::fit {

/// What smoothing did, by kind, and the curves before it: no rows for a kind that it left alone.
struct Smoothing {
  std::array<SmoothingReport, kCurveKinds> report;
  std::array<Controls, kCurveKinds> own_control, own_covariance;
};

/// Lets neighbouring points share what they know of a curve (docs/method.md, section 16): controls
/// and covariance of `fitted`, which are the points' own before, become those of a Gaussian Markov
/// random field about these. Per kind, points take part that were fitted and have a band; others,
/// and points without neighbours, stay as they are. Where the strength is 0 nothing is touched.
/// Throws Error when options.triangles name points that are not there. The other headers of this
/// folder are its own.
Smoothing smooth_curves(const BodyData& body, const std::vector<CurveRows>& rows,
                        const BodyBases& bases, const FitOptions& options, FittedCurves& fitted);

}  // namespace palpate::fit
