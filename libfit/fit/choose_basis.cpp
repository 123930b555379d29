#include "libfit/fit/choose_basis.hpp"

#include <algorithm>
#include <cmath>

#include "libfit/fit/held_out.hpp"
#include "libfit/fit/words.hpp"

namespace palpate::fit {
namespace {

constexpr int kFewestGroups = 4;        // a point with fewer abscissae holds nothing out
constexpr double kSameAbscissa = 1e-3;  // of the range: rows closer than that are one group
constexpr double kSameDepth = 0.02;     // a drag over a curved surface wanders that much in depth
constexpr std::size_t kMostPoints = 64;  // enough for a 95th percentile
constexpr int kGrid = 64;               // where curvature is looked at
constexpr double kCurvatureShare = 0.5;  // the rest of the knots' density is even

CurveBasis even_basis(int degree, int pieces, double range) {
  CurveBasis basis{degree, {}};
  for (int i = 0; i < pieces; ++i) basis.knots_m.push_back(range * i / pieces);
  basis.knots_m.push_back(range);
  return basis;
}

// Mean sqrt of |f''| over points on the grid: what a piecewise curve must follow there.
std::vector<double> bend_density(const std::vector<PointEvidence>& points,
                                 const CurveBasis& reference, FitLoss loss) {
  const SplineTables tables = tabulate(reference);
  const auto spline = view(tables);
  const double range = reference.knots_m.back(), h = range / kGrid;
  const Eigen::VectorXd lower = Eigen::VectorXd::Zero(reference.size() - 1);
  std::vector<double> density(kGrid, 0.0);
  for (const PointEvidence& point : points) {
    const Eigen::VectorXd b = controls_of(
        fit_increments(spline, point.rows, lower, faint_smoothness(reference), loss));
    for (int i = 0; i < kGrid; ++i) {
      const double bend = runtime::curve_slope(spline, b.data(), (i + 1) * h) -
                          runtime::curve_slope(spline, b.data(), i * h);
      density[static_cast<std::size_t>(i)] += std::sqrt(std::abs(bend) * range / point.largest);
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
    const double bend = total > 0 ? density[static_cast<std::size_t>(i)] / total : 1.0 / kGrid;
    share[static_cast<std::size_t>(i) + 1] =
        share[static_cast<std::size_t>(i)] + kCurvatureShare * bend + (1 - kCurvatureShare) / kGrid;
  }
  CurveBasis basis{degree, {0.0}};
  int cell = 0;
  for (int k = 1; k < pieces; ++k) {
    const double wanted = share.back() * k / pieces;
    while (share[static_cast<std::size_t>(cell) + 1] < wanted) ++cell;
    const double lo = share[static_cast<std::size_t>(cell)];
    const double hi = share[static_cast<std::size_t>(cell) + 1];
    basis.knots_m.push_back(range * (cell + (wanted - lo) / (hi - lo)) / kGrid);
  }
  basis.knots_m.push_back(range);
  return basis;
}

// The basis of one kind from its rows at the points that can hold some out.
BasisReport search(const std::vector<PointEvidence>& points, const CurveBasis& normal, int wanted,
                   double range, const FitOptions& options) {
  BasisReport report;
  report.points = static_cast<int>(points.size());
  std::vector<double> groups;
  for (const PointEvidence& point : points) groups.push_back(point.rows.back().group + 1);
  const int parameters = static_cast<int>(0.8 * median(groups));  // that a training fold can carry
  const int most = std::clamp(parameters - options.degree + 1, 1, options.most_pieces);
  const auto density =
      bend_density(points, even_basis(options.degree, std::min(most, 8), range), options.loss);

  const auto meets = [&](const Candidate& c) {
    return c.evidence.heldout_error <= options.tolerance;
  };
  std::vector<Candidate> candidates;  // the better placement for each number of pieces
  std::size_t best = 0;
  for (int pieces = wanted > 0 ? wanted : 1; pieces <= std::max(most, wanted);
       pieces += pieces < 6 ? 1 : 2) {
    Candidate candidate = judge(points, normal, even_basis(options.degree, pieces, range), false,
                                options.loss);
    report.evidence.push_back(candidate.evidence);
    if (pieces > 1) {
      Candidate other = judge(points, normal,
                              curvature_basis(options.degree, pieces, range, density), true,
                              options.loss);
      report.evidence.push_back(other.evidence);
      if (other.mean_square < candidate.mean_square) candidate = std::move(other);
    }
    candidates.push_back(std::move(candidate));
    if (candidates.back().mean_square < candidates[best].mean_square) best = candidates.size() - 1;
    if (wanted > 0 || meets(candidates.back())) break;
    if (candidates.size() > best + 4) break;  // four in a row that do not help
  }

  std::size_t chosen = meets(candidates.back()) ? candidates.size() - 1 : best;
  if (!meets(candidates.back()))
    for (std::size_t i = best + 1; i-- > 0;)
      if (is_as_good(candidates[i], candidates[best], options.tolerance)) chosen = i;
  const BasisEvidence& evidence = candidates[chosen].evidence;
  report.basis = candidates[chosen].basis;
  report.reason = wanted > 0 ? "pieces as asked, the better placement of two"
                  : evidence.heldout_error <= options.tolerance
                      ? "fewest pieces whose held-out error of " + percent(evidence.heldout_error) +
                            " meets the tolerance"
                      : "held-out error of " + percent(evidence.heldout_error) +
                            " is above the tolerance, but more pieces hardly lower it: rows "
                            "scatter, or the force "
                            "depends on more than this deflection";
  return report;
}

std::vector<std::size_t> evenly(const std::vector<std::size_t>& all) {
  if (all.size() <= kMostPoints) return all;
  std::vector<std::size_t> some;
  for (std::size_t i = 0; i < kMostPoints; ++i) some.push_back(all[i * all.size() / kMostPoints]);
  return some;
}

std::vector<PointEvidence> evidence_for(int kind, std::vector<PointRows>& rows, double range,
                                        const CurveBasis& normal, FitLoss loss) {
  std::vector<std::size_t> able;
  for (std::size_t p = 0; p < rows.size(); ++p)
    if (group_by_abscissa(rows[p].curve[static_cast<std::size_t>(kind)], range,
                          kind == 2 ? kSameDepth : kSameAbscissa) >= kFewestGroups)
      able.push_back(p);
  std::vector<PointEvidence> out;
  for (const std::size_t p : evenly(able)) {
    PointEvidence point{unit_weights(rows[p].curve[static_cast<std::size_t>(kind)]), 0, 0, {}};
    for (const CurveRow& row : point.rows) point.largest = std::max(point.largest, row.f);
    if (!(point.largest > 0)) continue;
    if (kind == static_cast<int>(CurveKind::limit)) {
      const SplineTables tables = tabulate(normal);
      point.normal = fit_increments(view(tables), unit_weights(rows[p].curve[0]),
                                    Eigen::VectorXd::Zero(normal.size() - 1),
                                    faint_smoothness(normal), loss);
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
                                                  std::vector<PointRows>& rows,
                                                  const FitOptions& options) {
  double reach = 0;
  for (const PointRows& point : rows) reach = std::max(reach, point.lateral_reach);
  const std::array<double, kCurveKinds> range{1.0, reach > 0 ? reach : 1.0, 1.0};

  std::array<BasisReport, kCurveKinds> reports;
  for (int kind = 0; kind < kCurveKinds; ++kind) {
    const auto k = static_cast<std::size_t>(kind);
    BasisReport& report = reports[k];
    const int wanted = options.pieces[k];
    if (!options.knots_m[k].empty()) {
      report.basis = {options.degree, options.knots_m[k]};
      for (double& knot : report.basis.knots_m) knot /= body.length_m;
      report.reason = "knots as given";
      for (PointRows& point : rows) group_by_abscissa(point.curve[k], range[k], kSameAbscissa);
      continue;
    }
    const CurveBasis& normal = reports[0].basis;
    const auto points = evidence_for(kind, rows, range[k], normal, options.loss);
    if (!points.empty()) {
      report = search(points, normal, wanted, range[k], options);
    } else if (kind == static_cast<int>(CurveKind::limit) && wanted == 0) {
      report.basis = normal;
      report.reason = "too few depths with slip to hold any out: knots of the normal curve";
    } else {
      report.basis = even_basis(options.degree, wanted > 0 ? wanted : 1, range[k]);
      report.reason = wanted > 0 ? "pieces as asked, even for want of rows to hold out"
                                 : "too few rows to hold any out: one piece";
    }
  }
  return reports;
}

}  // namespace palpate::fit
