#include <algorithm>
#include <cmath>

#include "libfit/core/statistics.hpp"
#include "libfit/core/text.hpp"
#include "libfit/fit/fit_steps.hpp"
#include "libfit/fit/rows/held_out.hpp"

namespace palpate::fit {
namespace {

constexpr int kFewestGroups = 4;         // a point with fewer abscissae holds nothing out
constexpr double kSameAbscissa = 1e-3;   // of the range: rows closer than that are one group
constexpr double kSameDepth = 0.02;      // a drag over a curved surface wanders that much in depth
constexpr int kMaxPieces = 12;           // the search stops here
constexpr std::size_t kMaxPoints = 64;   // enough for a 95th percentile
constexpr int kGrid = 64;                // where curvature is looked at
constexpr double kCurvatureShare = 0.5;  // the rest of the knots' density is even

CurveBasis even_basis(int degree, int pieces, double range) {
  CurveBasis basis{degree, {}};
  for (int i = 0; i < pieces; ++i) basis.knots_m.push_back(range * i / pieces);
  basis.knots_m.push_back(range);
  return basis;
}

// Mean sqrt of |f''| over points on the grid: what a piecewise curve must follow there.
std::vector<double> curvature_density(const std::vector<PointEvidence>& points,
                                      const CurveBasis& reference) {
  const SplineTables tables = tabulate(reference);
  const auto spline = view(tables);
  const double range = reference.knots_m.back(), h = range / kGrid;
  std::vector<double> density(kGrid, 0.0);
  for (const PointEvidence& point : points) {
    const Eigen::VectorXd b = controls_of(fit_smooth(reference, point.rows));
    for (int i = 0; i < kGrid; ++i) {
      const double curvature = runtime::curve_slope(spline, b.data(), (i + 1) * h) -
                               runtime::curve_slope(spline, b.data(), i * h);
      density[i] += std::sqrt(std::abs(curvature) * range / point.largest);
    }
  }
  return density;
}

// Knots at equal shares of the density, mixed with an even one.
CurveBasis curvature_basis(int degree, int pieces, double range,
                           const std::vector<double>& density) {
  double total = 0;
  for (const double d : density) total += d;
  std::vector<double> share(kGrid + 1, 0.0);
  for (int i = 0; i < kGrid; ++i) {
    const double curvature = total > 0 ? density[i] / total : 1.0 / kGrid;
    share[i + 1] = share[i] + kCurvatureShare * curvature + (1 - kCurvatureShare) / kGrid;
  }
  CurveBasis basis{degree, {0.0}};
  int cell = 0;
  for (int k = 1; k < pieces; ++k) {
    const double wanted = share.back() * k / pieces;
    while (share[cell + 1] < wanted) ++cell;
    const double lo = share[cell];
    const double hi = share[cell + 1];
    basis.knots_m.push_back(range * (cell + (wanted - lo) / (hi - lo)) / kGrid);
  }
  basis.knots_m.push_back(range);
  return basis;
}

// Bases of one kind for any number of pieces.
class KnotPlacer {
 public:
  KnotPlacer(const std::vector<PointEvidence>& points, const CurveBasis& normal, double range,
             int most, const FitOptions& options)
      : points_(points),
        normal_(normal),
        range_(range),
        options_(options),
        density_(curvature_density(points, even_basis(options.degree, std::min(most, 8), range))) {}

  /// The better of two placements.
  BasisCandidate best(int pieces, std::vector<BasisEvidence>& evidence) const {
    BasisCandidate best =
        judge(points_, normal_, even_basis(options_.degree, pieces, range_), KnotPlacement::even);
    evidence.push_back(best.evidence);
    if (pieces == 1) return best;
    BasisCandidate other =
        judge(points_, normal_, curvature_basis(options_.degree, pieces, range_, density_),
              KnotPlacement::curvature);
    evidence.push_back(other.evidence);
    return other.mean_square < best.mean_square ? std::move(other) : std::move(best);
  }

 private:
  const std::vector<PointEvidence>& points_;
  const CurveBasis& normal_;
  double range_;
  const FitOptions& options_;
  std::vector<double> density_;
};

// The first candidate within the tolerance, or else as good as the best, where more pieces do not
// lower what neighbouring rows are off together.
std::size_t fewest(const std::vector<BasisCandidate>& candidates, std::size_t best,
                   double tolerance) {
  if (meets(candidates.back(), tolerance)) best = candidates.size() - 1;
  for (std::size_t i = 0; i < candidates.size(); ++i)
    if (candidates[i].evidence.heldout_error <= tolerance &&
        is_as_good_locally(candidates[i], candidates[best], tolerance))
      return i;
  for (std::size_t i = 0; i < best; ++i)
    if (is_as_good(candidates[i], candidates[best], tolerance)) return i;
  return best;
}

std::string reason_for(const BasisCandidate& chosen, bool is_wanted, double tolerance) {
  const BasisEvidence& evidence = chosen.evidence;
  const std::string held_out = "held-out error of " + percent(evidence.heldout_error);
  if (is_wanted) return "pieces as asked, the better placement of their knots";
  if (meets(chosen, tolerance)) return "fewest pieces whose " + held_out + " meets the tolerance";
  if (evidence.heldout_error <= tolerance)
    return held_out + " meets the tolerance; what neighbouring rows are off together, up to " +
           percent(evidence.local_error) + ", more pieces hardly lower";
  return held_out +
         " is above the tolerance, but more pieces hardly lower it: rows scatter, or the force "
         "depends on more than this deflection";
}

// The basis of one kind from its rows at the points that can hold some out; of min_pieces
// or more where rows can carry them.
BasisReport search(const std::vector<PointEvidence>& points, const CurveBasis& normal, int wanted,
                   int min_pieces, double range, const FitOptions& options) {
  BasisReport report;
  report.points = static_cast<int>(points.size());
  std::vector<double> groups;
  for (const PointEvidence& point : points) groups.push_back(point.rows.back().group + 1);
  const int parameters = static_cast<int>(0.8 * median(groups));  // that a training fold can carry
  const int most = std::clamp(parameters - options.degree + 1, 1, kMaxPieces);
  const KnotPlacer placer(points, normal, range, most, options);

  std::vector<BasisCandidate> candidates;  // the best placement for each number of pieces
  std::size_t best = 0;
  for (int pieces = wanted > 0 ? wanted : std::min(min_pieces, most);
       pieces <= std::max(most, wanted); pieces += pieces < 6 ? 1 : 2) {
    candidates.push_back(placer.best(pieces, report.evidence));
    if (candidates.back().mean_square < candidates[best].mean_square) best = candidates.size() - 1;
    if (wanted > 0 || meets(candidates.back(), options.tolerance)) break;
    if (candidates.size() > best + 4) break;  // four in a row that do not help
  }

  const std::size_t chosen = fewest(candidates, best, options.tolerance);
  report.basis = candidates[chosen].basis;
  report.heldout_error = candidates[chosen].evidence.heldout_error;
  report.reason = reason_for(candidates[chosen], wanted > 0, options.tolerance);
  return report;
}

// At most `most` of the numbers, evenly taken in their order.
std::vector<std::size_t> evenly(const std::vector<std::size_t>& all, std::size_t most) {
  if (all.size() <= most) return all;
  std::vector<std::size_t> some;
  for (std::size_t i = 0; i < most; ++i) some.push_back(all[i * all.size() / most]);
  return some;
}

std::vector<PointEvidence> evidence_for(int kind, std::vector<CurveRows>& rows, double range,
                                        const CurveBasis& normal) {
  std::vector<std::size_t> able;
  for (std::size_t p = 0; p < rows.size(); ++p)
    if (group_by_abscissa(rows[p].curve[kind], range, kind == 2 ? kSameDepth : kSameAbscissa) >=
        kFewestGroups)
      able.push_back(p);
  std::vector<PointEvidence> out;
  for (const std::size_t p : evenly(able, kMaxPoints)) {
    PointEvidence point{unit_weights(rows[p].curve[kind]), 0, 0, {}};
    for (const CurveRow& row : point.rows) point.largest = std::max(point.largest, row.f);
    if (!(point.largest > 0)) continue;
    if (kind == static_cast<int>(CurveKind::limit)) {
      const SplineTables tables = tabulate(normal);
      point.normal = fit_smooth(normal, unit_weights(rows[p].curve[0]));
      std::vector<double> ratios;
      for (const CurveRow& row : point.rows) {
        const double f = increment_weights(view(tables), row.x).dot(point.normal);
        if (f > 0) ratios.push_back(row.f / f);
      }
      point.friction = median(ratios);
    }
    out.push_back(std::move(point));
  }
  return out;
}

}  // namespace

std::array<BasisReport, kCurveKinds> choose_bases(const BodyData& body,
                                                  std::vector<CurveRows>& rows,
                                                  const FitOptions& options) {
  double reach = 0;
  for (const CurveRows& point : rows) reach = std::max(reach, point.lateral_reach);
  const std::array<double, kCurveKinds> range{1.0, reach > 0 ? reach : 1.0, 1.0};

  std::array<BasisReport, kCurveKinds> reports;
  for (int kind = 0; kind < kCurveKinds; ++kind) {
    BasisReport& report = reports[kind];
    const int wanted = options.pieces[kind];
    if (!options.knots_m[kind].empty()) {
      report.basis = {options.degree, options.knots_m[kind]};
      for (double& knot : report.basis.knots_m) knot /= body.length_m;
      report.reason = "knots as given";
      for (CurveRows& point : rows)
        group_by_abscissa(point.curve[kind], range[kind], kSameAbscissa);
      continue;
    }
    const CurveBasis& normal = reports[0].basis;
    const auto points = evidence_for(kind, rows, range[kind], normal);
    if (!points.empty()) {
      report = search(points, normal, wanted, 1, range[kind], options);
    } else if (kind == static_cast<int>(CurveKind::limit) && wanted == 0) {
      report.basis = normal;
      report.reason = "too few depths with slip to hold any out: knots of the normal curve";
    } else {
      report.basis = even_basis(options.degree, wanted > 0 ? wanted : 1, range[kind]);
      report.reason = wanted > 0 ? "pieces as asked, even for want of rows to hold out"
                                 : "too few rows to hold any out: one piece";
    }
  }
  return reports;
}

// Of one cubic the curvature, which is the bed, is a line, and that of a ball on a half-space falls
// like 1/sqrt(d).
constexpr int kMinBedPieces = 2;

std::optional<BasisReport> choose_bed_basis(const std::vector<CurveRows>& rows,
                                            const FitOptions& options) {
  if (options.pieces[0] > 0 || !options.knots_m[0].empty()) return std::nullopt;
  std::vector<CurveRows> pressed(rows.size());
  for (std::size_t p = 0; p < rows.size(); ++p)
    for (const CurveRow& row : rows[p].curve[0])
      if (row.is_pressed) pressed[p].curve[0].push_back(row);
  const auto points = evidence_for(0, pressed, 1.0, {});
  if (points.empty()) return std::nullopt;
  FitOptions exact = options;
  exact.tolerance = std::min(options.tolerance, kWeightFloor);
  BasisReport report = search(points, {}, 0, kMinBedPieces, 1.0, exact);
  report.reason = "its curvature is the bed: pieces whose held-out error of presses, " +
                  percent(report.heldout_error, 2) + ", more hardly lower";
  return report;
}

}  // namespace palpate::fit
