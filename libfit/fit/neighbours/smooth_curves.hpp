#pragma once

#include "libfit/fit/neighbours/smoothing_report.hpp"
#include "libfit/fit/point/fit_point.hpp"

namespace palpate::fit {

/// Lets neighbouring points share what they know of a curve (docs/method.md, section 16): controls
/// and covariance of `fitted` become those of a Gaussian Markov random field about the points' own
/// estimates, `own` keeps these, residuals and scores are taken again. fitted and results: of the
/// points by themselves, results in point order. Per kind, points take part that were fitted and
/// have a band; others, and points without neighbours, stay as they are, and every status stays.
/// Where the strength is 0 nothing is touched. read_rows: samples with the rows of kept points that
/// `samples` lacks; their scores are taken again only where their curves moved.
std::array<SmoothingReport, kCurveKinds> smooth_curves(
    const Samples& samples, const BodyData& body, const std::vector<PointRows>& rows,
    const BodyBases& bases, const FitOptions& options, FittedCurves& fitted,
    std::vector<PointResult>& results, const ReadRows& read_rows = {});

}  // namespace palpate::fit
