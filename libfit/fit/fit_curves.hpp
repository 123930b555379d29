#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/core/progress.hpp"
#include "libfit/core/relative_error.hpp"
#include "libfit/core/row_index.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/fit/neighbours/smoothing_report.hpp"

namespace palpate {

/// How a row far from the curves counts. `huber` grows linearly past three robust standard
/// deviations, `cauchy` logarithmically past two and a half.
enum class FitLoss : std::int8_t { squared = 0, huber = 1, cauchy = 2 };
struct FitLossName {
  FitLoss loss;
  std::string_view name;
};
inline constexpr std::array<FitLossName, 3> kFitLossNames{{
    {FitLoss::squared, "squared"},
    {FitLoss::huber, "huber"},
    {FitLoss::cauchy, "cauchy"},
}};

/// What may be unknown of a recording besides the body's curves.
enum class SensorPart : std::int8_t { contact = 0, bias = 1, drift = 2 };
struct SensorPartName {
  SensorPart part;
  std::string_view name;
};
inline constexpr std::array<SensorPartName, 3> kSensorPartNames{{
    {SensorPart::contact, "contact"},  ///< where the tip touched first
    {SensorPart::bias, "bias"},        ///< of the force along the normal
    {SensorPart::drift, "drift"},      ///< likewise, linear from the first row to the last
}};

/// What a user may decide about a fit; the defaults suit simulated samples.
struct FitOptions {
  std::optional<CurveFamily> family{};  ///< none: by held-out error
  bool judges_family = false;           ///< a family that was asked for gets its evidence, too
  int degree = 3;                       ///< of every curve, 1 to 4; 0: by held-out error
  /// Pieces of the normal, lateral and limit basis; 0: the fewest that held-out rows support.
  std::array<int, kCurveKinds> pieces{0, 0, 0};
  /// Knots of each kind [m], taken as they are; empty: placed from the samples.
  std::array<std::vector<double>, kCurveKinds> knots_m{};
  int max_pieces = 12;  ///< the search for `pieces` stops here
  /// Held-out force error that is good enough, relative; 0: as good as the rows can tell.
  double tolerance = 0.02;
  /// A point whose relative residual is above this is `poor`: the force JND (docs/method.md, 8).
  double poor_above = kForceJnd;
  FitLoss loss = FitLoss::huber;
  /// Weight floor as a fraction of the point's typical force: rows are weighted by
  /// 1 / sqrt(force_error^2 + floor^2).
  double weight_floor = 1e-3;
  double default_friction = kDefaultFriction;  ///< L / f^z where no row slips
  /// f^r'/f^z' where no row sticks: 2 (1-nu)/(2-nu) of a half-space, here an incompressible one.
  double default_lateral_ratio = 2.0 / 3.0;
  /// Parts of each experiment's recording that are fitted with the curves, by SensorPart; each is
  /// bounded by four standard deviations of what is known of it beforehand.
  std::array<bool, 3> frees{false, false, false};
  /// Deviation of a contact point where the recording states none; 0: such an experiment keeps its.
  double contact_deviation_m = 0;
  double sensor_deviation = 0.05;  ///< of bias and drift, as a share of the point's typical force
  /// Strength of smoothing over neighbouring points, SmoothingReport::strength; none: the least
  /// that rows held out support, which is 0 where neighbours tell nothing new.
  std::optional<double> smoothing = 0;
  /// Rows index the points: whose edges say which are neighbours. Empty: points near each other on
  /// one sheet (point_graph).
  Triangles triangles{};
  int jobs = 0;           ///< threads, 0: all. Results do not depend on it.
  int worst_points = 10;  ///< length of FitReport::worst
  /// Curves of an earlier fit, which must outlive the call: its bases, family and strengths of
  /// smoothing are kept, and points fitted from the same rows with the same options keep their
  /// curves.
  const FittedCurves* warm_start = nullptr;
};

/// Options with what the samples say of their probe and body, the rest at its defaults: friction,
/// and the lateral ratio of a half-space of the body's Poisson's ratio.
FitOptions options_for(const Samples& samples);

/// How knots got where they are: equal pieces, equal shares of the curves' bend, or where curves
/// with knots there are nearest to the rows.
enum class KnotPlacement : std::int8_t { even = 0, curvature = 1, identified = 2 };

/// One candidate of the search for a basis: mean error of rows the curve did not see.
struct BasisEvidence {
  int pieces = 0;
  KnotPlacement placement = KnotPlacement::even;
  double heldout_error = 0;  ///< 95th percentile over points of the relative rms error
  /// Likewise of the largest error that three neighbouring abscissae have in common.
  double local_error = 0;
};

/// Why a kind got its basis.
struct BasisReport {
  CurveBasis basis;
  std::vector<BasisEvidence> evidence;  ///< in the order tried; empty when the user chose
  int points = 0;                       ///< that had rows to hold out
  double heldout_error = 0;             ///< of the basis; 0 where none could be held out
  std::string reason;                   ///< a sentence
};

/// Relative error of rows that curves of a family did not see.
struct FamilyEvidence {
  CurveFamily family = CurveFamily::separable;
  double median_error = 0, p95_error = 0;
};

/// Why the body got its family.
struct FamilyReport {
  CurveFamily family = CurveFamily::separable;
  /// Of the families tried; of one that was asked for where FitOptions::judges_family.
  std::vector<FamilyEvidence> evidence;
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

/// How the fit went. All but `seconds` is independent of the number of threads.
struct FitReport {
  std::array<BasisReport, kCurveKinds> kind;
  std::string degree_reason;  ///< of a degree that was chosen, a sentence
  FamilyReport family;
  std::array<SmoothingReport, kCurveKinds> smoothing;
  std::vector<WorstPoint> worst;
  std::size_t kept = 0;  ///< points that a warm start did not fit again
  std::size_t good = 0, underdetermined = 0, poor = 0, failed = 0;  ///< points
  std::size_t rows = 0;                                             ///< in the samples
  std::size_t rows_used = 0;                                        ///< fitted and scored
  std::size_t rows_not_good = 0;                                    ///< left out for their status
  std::size_t rows_not_finite = 0;  ///< left out although `good`: NaN or infinite
  std::size_t rows_cut = 0;         ///< after the first row left out of a drag or path
  /// |force difference| / max(|force|, 5 % of the point's typical force), over all rows used.
  double median_relative_error = 0, p95_relative_error = 0, max_relative_error = 0;
  /// Half widths of the curves' bands of 90 % at the end of their rows, over the curve there:
  /// median over the points that have one, and the widest.
  std::array<double, kCurveKinds> median_band{}, widest_band{};
  std::array<Eigen::Index, kCurveKinds> widest_point{-1, -1, -1};
  bool is_stopped = false;  ///< Progress asked to stop; the points left are `failed`
  double seconds = 0;       ///< wall clock
};

/// Response curves at every test point, identified from its experiments (docs/method.md, 3 to 5).
/// Rows are predicted by replaying their experiment through the response model, friction limit
/// included; weighted force differences are minimised over the increments of the control values,
/// bounded below by zero, so every curve is monotone and zero at zero. Points are independent but
/// for FitOptions::smoothing, which starts from all of them and leaves each its status.
/// A point with too little data gets the curves its message names and `underdetermined`; one with
/// none gets zero curves and `failed`; others are not affected. A warm start brings what the fit
/// would on the earlier bases, in the time that the changed points take. Throws Error on options
/// out of range and on samples whose arrays do not belong together.
FittedCurves fit_curves(const Samples& samples, const FitOptions& options = {},
                        const Progress& progress = {}, FitReport* report = nullptr);

/// Samples with all test points and the rows of those wanted (P).
using ReadRows = std::function<Samples(const std::vector<char>& is_wanted)>;

/// What fit_curves brings from a warm start, by reading the rows of changed points alone. points:
/// the test points, without rows; index: of all `rows` rows. Nothing where all rows are needed:
/// sensors are freed, only some points state force errors, smoothing is chosen anew, most points
/// have changed.
std::optional<FittedCurves> refit_curves(const Samples& points, const RowIndex& index,
                                         std::size_t rows, const ReadRows& read_rows,
                                         const FitOptions& options, const Progress& progress = {},
                                         FitReport* report = nullptr);

}  // namespace palpate
