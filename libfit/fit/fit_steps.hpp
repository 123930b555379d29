#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libfit/fit/point/point.hpp"

// The steps of fit_curves(), in the order in which it takes them.

namespace palpate::fit {

/// Samples without times whose forces, torques and errors are over the ratio of the curves' forces
/// with time to those in slow motion (docs/method-body.md, section 24). Rows of a press that
/// unloads, and those at which by the curves the tool has left the body, become `no_contact`.
/// curves: rings at the same points; rows of points that failed stay as they are.
Samples in_slow_motion(const Samples& timed, const FittedCurves& curves);

/// Options of a warm start: bases and family as the earlier fit had them. Throws Error where its
/// curves are of several degrees.
FitOptions as_before(FitOptions options);

/// Sets PointExperiment::unknown as the options ask. The contact point of an experiment is as
/// uncertain as its recordings' (the mean of those pooled). Throws Error when contact points are to
/// be found and no recording states how uncertain any of them is.
void add_nuisances(const Samples& samples, const FitOptions& options, BodyData& body);

/// True where anything is unknown of any experiment.
bool has_nuisances(const BodyData& body);

/// A point's rows as they would have been recorded without its nuisance values.
PointData without_nuisances(PointData point, const std::vector<NuisanceValues>& nuisance);

/// The three bases of the body in units of its `length_m`, and why. The caller scales knots.
/// A user's knots and pieces are taken; otherwise the fewest pieces are sought whose curves
/// predict held-out rows within the tolerance or, where noise forbids that, as well as the best.
/// Work: at most 64 points, evenly taken.
std::array<BasisReport, kCurveKinds> choose_bases(const BodyData& body,
                                                  std::vector<CurveRows>& rows,
                                                  const FitOptions& options);

/// The basis of f^z for a law that reads its curvature, in units of the body's `length_m`: the
/// fewest pieces whose curves predict held-out rows of presses as well as the best, to a standard
/// error or the floor of the rows' weights, whatever the tolerance. Rows of drags do not count:
/// beside the point the force is not f^z alone. None where the user decides the normal basis or no
/// point presses enough to hold rows out.
std::optional<BasisReport> choose_bed_basis(const std::vector<CurveRows>& rows,
                                            const FitOptions& options);

/// Relative error of rows that curves of a family were not fitted to.
struct FamilyEvidence {
  double median_error = 0, p95_error = 0;
  std::size_t rows = 0;  ///< held out, whose points had curves
};

/// Holds every other row of each experiment out in turn, its path still replayed. At most 24
/// points, evenly taken.
FamilyEvidence judge_family(const BodyData& body, const std::vector<CurveRows>& rows,
                            const BodyBases& bases, const FitOptions& options);

/// A share of the sway of each point [m/N].
std::vector<Mat3> sways_of(const Samples& samples, double share);

/// Sways [m/N] whose coupling of along and across the normal is such that contacts with these rings
/// need no side force in presses (M33b), as far as they stay positive definite. body: with `sways`
/// subtracted.
std::vector<Mat3> turned_sways(const BodyData& body, std::vector<Mat3> sways,
                               const RingPrior& rings);

/// True where something that a fit may take is worth it, such as a body's computed sway: p95 is
/// lower by a tenth and the median no higher, or the median is lower by a tenth and p95 not worse
/// by one; not where it leaves a tenth of the rows unjudged. Of a few dragged points p95 is that of
/// the one beside a fold.
bool predicts_better(const FamilyEvidence& without, const FamilyEvidence& with);

/// By how much ln lambda, mu_0, mu_1 D and gamma D of a body's points differ from their lines, D
/// the depth of its deepest row: friction by as much there as at first touch.
inline constexpr RingConstants kUsualRings{0.2, 0.03, 0.03, 0.03};

/// Constants of a point's rings as fitted to its drags, and their standard errors. log_force: of
/// its press [ln N], see RingPrior.
struct RingPoint {
  double log_force = 0;
  RingConstants constant{}, error{};
};
/// From lambda, mu_0, mu_1 and gamma and their errors, four numbers each.
RingPoint ring_point(double log_force, const double* constant, const double* error);

/// Constants of a body by its dragged points, and the line of lambda through them over the force of
/// their presses (RingPrior). deviation: of a point's constants about these, above 0. A point
/// weighs 1/(deviation^2 + error^2). The slope is the weighted median over pairs of points (Theil
/// 1950, Sen 1968, doi:10.1080/01621459.1968.10480934), drawn to 0 where the points' forces hardly
/// differ; of points alike in error a third may be anything. theory, where it is known, counts as
/// one point that its error leaves exact. Not for no point.
RingPrior ring_lines(const std::vector<RingPoint>& points, const RingConstants& deviation,
                     const std::optional<RingConstants>& theory = {});

/// Rows for curves.h5; none where nothing was unknown.
FittedRecordings collect_nuisances(const BodyData& body, const std::vector<PointResult>& results);

/// The report of a fit of all points; the number of rows, family, time and whether it was
/// stopped are left to the caller. rows: of the curves of each point.
FitReport make_report(const BodyData& body, const std::vector<CurveRows>& rows,
                      const BodyBases& bases, const FittedCurves& fitted,
                      const std::vector<PointResult>& results, const FitOptions& options);

}  // namespace palpate::fit
