#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/core/stated_error.hpp"

namespace palpate {

/// How knots got where they are: equal pieces, or equal shares of the curves' curvature.
enum class KnotPlacement : std::int8_t { even = 0, curvature = 1 };

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

/// Why the body got its family.
struct FamilyReport {
  CurveFamily family = CurveFamily::separable;
  bool sways = false;  ///< its law stands in series with the sway of the body as a whole
  std::string reason;
};

/// Constants of a body's rings, of a point of median force as the dragged ones tell (ring_lines),
/// beside theory's; NaN where samples do not say what theory needs.
struct RingsReport {
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  int points = 0;  ///< that were dragged; without any nothing is judged
  double lambda = 0, friction = 0, friction_slope_1_m = 0, spread_1_m = 0;
  /// Standard errors of a point's, medians over the same points; of g_2 at full
  /// depth: share of the normal force.
  double lambda_deviation = kUnknown, friction_deviation = kUnknown;
  double friction_slope_deviation_1_m = kUnknown, spread_deviation_1_m = kUnknown;
  double side_deviation = kUnknown;
  double expected_lambda = kUnknown, expected_friction = kUnknown;
  double expected_friction_slope_1_m = kUnknown;
  std::vector<Eigen::Index> uneven;  ///< points whose lambda is far from the median
  std::string warning;               ///< what is far from theory, and likely reasons; or empty
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

/// Points by how they were fitted. kept: a warm start did not fit them again.
struct PointCounts {
  std::size_t good = 0, underdetermined = 0, poor = 0, failed = 0, kept = 0;
};

/// Rows of the samples. used: fitted and scored. Left out: not_good for their status, not_finite
/// although `good`, cut after the first row left out of a drag or path.
struct ReportedRows {
  std::size_t all = 0, used = 0, not_good = 0, not_finite = 0, cut = 0;
};

/// Figures of relative force differences as a statement has them (M11a).
struct RelativeErrors {
  double median = 0, p95 = 0, max = 0;
};
RelativeErrors relative_errors(const std::vector<ForceError>& rows);

/// Half widths of the curves' bands of 90 % at the end of their rows, over the curve there: median
/// over the points that have one, and the widest, with its point; -1: none.
struct BandWidths {
  std::array<double, kCurveKinds> median{}, widest{};
  std::array<Eigen::Index, kCurveKinds> widest_point{-1, -1, -1};
};

/// How the fit went. All but `seconds` is independent of the number of threads.
struct FitReport {
  std::array<BasisReport, kCurveKinds> kind;
  FamilyReport family;
  RingsReport rings;
  /// What points that were only pressed got as lateral and limit curves or as rings, a sentence;
  /// empty where drags tell. Such points are graded by their normal curve alone.
  std::string assumed;
  std::vector<WorstPoint> worst;
  PointCounts points;
  ReportedRows rows;
  RelativeErrors error;  ///< of the rows used
  BandWidths bands;
  bool is_stopped = false;  ///< Progress asked to stop; the points left are `failed`
  double seconds = 0;       ///< wall clock
};

}  // namespace palpate
