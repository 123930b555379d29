#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/core/progress.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/core/stated_error.hpp"

namespace palpate {

/// Unknowns of a recording beside the body's curves.
enum Nuisance : int { kContact, kBias, kDrift, kNuisances };
inline constexpr std::array<std::string_view, kNuisances> kNuisanceNames{
    "contact",  ///< the place at which the tip touched first
    "bias",     ///< constant error of the force along the normal
    "drift",    ///< its error that is linear from the first row to the last
};

/// Choices of a user about a fit; the defaults suit simulated samples.
struct FitOptions {
  CurveFamily family = CurveFamily::rings;
  /// The rigid motion of the body is subtracted from deflections; none: where that predicts
  /// held-out rows better.
  std::optional<bool> sways{};
  int degree = 3;  ///< of every curve, 1 to 4
  /// Pieces of the normal, lateral and limit basis; 0: the fewest that held-out rows support.
  std::array<int, kCurveKinds> pieces{0, 0, 0};
  /// Knots of each kind [m], taken as they are; empty: placed from the samples.
  std::array<std::vector<double>, kCurveKinds> knots_m{};
  /// Held-out force error that is good enough, relative; 0: as good as the rows allow.
  double tolerance = 0.02;
  double default_friction = kDefaultFriction;  ///< L / f^z where no row slips
  /// f^r'/f^z' where no row sticks: 2 (1-nu)/(2-nu) of a half-space, here an incompressible one.
  double default_lateral_ratio = 2.0 / 3.0;
  /// Parts of each experiment's recording that are fitted with the curves, by Nuisance; each is
  /// bounded by four standard deviations of what is known of it beforehand.
  std::array<bool, kNuisances> estimates{false, false, false};
  int jobs = 0;  ///< threads, 0: all. Results do not depend on it.
  /// Curves of an earlier fit, which must outlive the call: its bases and family are kept.
  const FittedCurves* warm_start = nullptr;
};

/// Options with what the samples say of their probe and body, the rest at its defaults: friction,
/// and the lateral ratio of a half-space of the body's Poisson's ratio.
FitOptions options_for(const Samples& samples);

/// Why a kind got its basis.
struct BasisReport {
  CurveBasis basis;
  /// Relative error of rows that the curve did not see, p95 over points; 0: none was held out.
  double heldout_error = 0;
  std::string reason;  ///< a sentence
};

/// Why the body got its family.
struct FamilyReport {
  CurveFamily family = CurveFamily::separable;
  bool sways = false;  ///< its law stands in series with the rigid sway of the body
  std::string reason;
};

/// A point that the curves describe badly, worst first.
struct WorstPoint {
  Eigen::Index point = 0;
  std::string name;
  Vec3 position = Vec3::Zero();  ///< [m]
  double relative_residual = 0;  ///< rms residual over rms force
  double rms_residual_N = 0;
  double max_residual_N = 0;
  std::string reason;  ///< which experiment and row is worst, then the point's message
};

/// Points by how they were fitted.
struct PointCounts {
  std::size_t good = 0, underdetermined = 0, poor = 0, failed = 0;
};

/// Rows of the samples. used: fitted and scored. Left out: not_good for their status, not_finite
/// although `good`, cut after the first row left out of a drag or path.
struct ReportedRows {
  std::size_t all = 0, used = 0, not_good = 0, not_finite = 0, cut = 0;
};

/// Report of a fit. All but `seconds` is independent of the number of threads.
struct FitReport {
  std::array<BasisReport, kCurveKinds> kind;
  FamilyReport family;
  /// A sentence on the lateral and limit curves, or rings, of points that were only pressed; empty
  /// where drags determine them. Such points are graded by their normal curve alone.
  std::string assumed;
  std::vector<WorstPoint> worst;
  PointCounts points;
  ReportedRows rows;
  RelativeErrors error;     ///< of the rows used
  bool is_stopped = false;  ///< Progress asked to stop; the points left are `failed`
  double seconds = 0;       ///< wall clock
};

/// Response curves at every test point, identified from its experiments (docs/method.md, 3 to 5).
/// Rows are predicted by replaying their experiment through the response model, friction limit
/// included; weighted force differences are minimised over the increments of the control values,
/// bounded below by zero, so every curve is monotone and zero at zero. Points are independent.
/// Presses count along the normal alone (straighten_presses()).
/// A point with too little data gets the curves its message names and `underdetermined`; one with
/// none gets zero curves and `failed`; others are not affected. Throws Error on options out of
/// range and on samples whose arrays do not belong together.
FittedCurves fit_curves(const Samples& samples, const FitOptions& options = {},
                        const Progress& progress = {}, FitReport* report = nullptr);

}  // namespace palpate
