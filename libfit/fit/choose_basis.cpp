#include <algorithm>
#include <cmath>
#include <limits>

#include "libfit/core/stated_error.hpp"
#include "libfit/core/statistics.hpp"
#include "libfit/core/text.hpp"
#include "libfit/fit/fit_steps.hpp"

namespace palpate::fit {
namespace {

constexpr double kSameAbscissa = 1e-3;  // of the range: rows closer than that are one group
constexpr int kGrid = 64;               // where curvature is looked at

// Rows of one point for the choice of a basis.
struct PointEvidence {
  std::vector<CurveRow> rows;  // of unit weights, grouped by abscissa
  double largest = 0;          // force
  double friction = 0;         // limit kind only: L / f^z overall
  Eigen::VectorXd normal;      // limit kind only: increments of f^z; else empty
};

// A basis and how well its curves predict rows they did not see.
struct BasisCandidate {
  CurveBasis basis;
  double heldout_error = 0;          // p95 over points of the relative rms error
  double local_error = 0;            // of the largest error that three neighbouring abscissae share
  std::vector<double> squared = {};  // as stated, of every held-out row of every point
  double mean_square = 0;
};

// The largest of many medians of three: noise of deviation 1 reaches 1.5 in one point of three.
constexpr double kLocalShare = 1.5;

// The knowledge that fills gaps: a limit curve is shaped like f^z, others are smooth.
WeakPrior prior_for(const PointEvidence& point, const CurveBasis& normal, const CurveBasis& basis) {
  if (point.normal.size() == 0) return smoothness_prior(basis);
  return value_prior(transfer(normal, point.normal, basis, point.friction));
}

constexpr int kFolds = 5;  // a point's abscissae are held out a fifth at a time

// True where a fold holds the row out. Only interpolation is judged: the deepest group is never
// held out, and of a limit curve neither is the shallowest.
bool is_held_out(const PointEvidence& point, const CurveRow& row, int fold) {
  const int first = point.normal.size() > 0 ? 0 : -1;
  return row.group % kFolds == fold && row.group != first && row.group != point.rows.back().group;
}

// Errors of rows by group, each predicted by a fit that left its fold out; then, as one of them
// left them, those of the deepest group, which every fold sees.
struct HeldOutErrors {
  std::size_t rows = 0;  // held out
  std::vector<int> group;
  std::vector<double> relative;  // over the row's force
  std::vector<double> stated;    // likewise, down to the forces that an error statement counts
};
HeldOutErrors hold_out(const PointEvidence& point, const CurveBasis& normal,
                       const CurveBasis& basis) {
  const SplineTables tables = tabulate(basis);
  std::vector<double> error(point.rows.size(), std::numeric_limits<double>::quiet_NaN());
  for (int fold = 0; fold < kFolds; ++fold) {
    std::vector<CurveRow> training;
    for (const CurveRow& row : point.rows)
      if (!is_held_out(point, row, fold)) training.push_back(row);
    if (training.size() == point.rows.size()) continue;
    const Eigen::VectorXd increments = fit_increments(
        basis, training, Eigen::VectorXd::Zero(basis.size() - 1), prior_for(point, normal, basis));
    for (std::size_t i = 0; i < error.size(); ++i)
      if (const CurveRow& row = point.rows[i];
          is_held_out(point, row, fold) || row.group == point.rows.back().group)
        error[i] = increment_weights(view(tables), row.x).dot(increments) - row.f;
  }
  HeldOutErrors out;
  for (std::size_t i = 0; i < error.size(); ++i) {
    const CurveRow& row = point.rows[i];
    if (std::isnan(error[i])) continue;
    out.rows += row.group != point.rows.back().group;
    out.group.push_back(row.group);
    const double force_N = std::abs(row.f);
    out.relative.push_back(relative_error(error[i], force_N, relative_floor(point.largest)));
    out.stated.push_back(relative_error(error[i], force_N, relative_floor_N(point.largest)));
  }
  return out;
}

// The error of each row that its abscissa has in common with its neighbours: the median of three
// groups' median errors. What noise and single outliers leave of it is small.
std::vector<double> common_errors(const std::vector<int>& group, const std::vector<double>& error) {
  std::vector<double> of_group;
  std::vector<std::size_t> index;  // of each row, into of_group
  for (std::size_t i = 0; i < error.size();) {
    std::vector<double> same;
    const int here = group[i];
    for (; i < error.size() && group[i] == here; ++i) {
      same.push_back(error[i]);
      index.push_back(of_group.size());
    }
    of_group.push_back(median(std::move(same)));
  }
  std::vector<double> out;
  for (const std::size_t g : index) {
    if (of_group.size() < 3) {
      out.push_back(0);
      continue;
    }
    const std::size_t middle = std::clamp<std::size_t>(g, 1, of_group.size() - 2);
    out.push_back(std::abs(median({of_group[middle - 1], of_group[middle], of_group[middle + 1]})));
  }
  return out;
}

// Squares of the first errors, those of outliers clipped. What neighbours have in common is no
// outlier.
std::vector<double> clipped_squares(std::vector<double> error, std::size_t rows,
                                    const std::vector<double>& common) {
  error.resize(rows);
  for (double& e : error) e = std::abs(e);
  const double clip = 4 * robust_deviation(error);
  for (std::size_t i = 0; i < error.size(); ++i) {
    if (clip > 0) error[i] = std::min(error[i], std::max(clip, common[i]));
    error[i] *= error[i];
  }
  return error;
}

// Standard error of the difference between the mean squares of two candidates, row by row.
double error_of_difference(const BasisCandidate& a, const BasisCandidate& b) {
  const double mean = a.mean_square - b.mean_square;
  double square = 0;
  for (std::size_t i = 0; i < a.squared.size(); ++i)
    square += std::pow(a.squared[i] - b.squared[i] - mean, 2);
  return std::sqrt(square) / double(a.squared.size());
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return values.empty() ? 0 : sum / double(values.size());
}

// Judges `basis` by each fold in turn. normal: basis of f^z.
BasisCandidate judge(const std::vector<PointEvidence>& points, const CurveBasis& normal,
                     const CurveBasis& basis) {
  BasisCandidate candidate{basis};
  std::vector<double> point_errors, local_errors;
  for (const PointEvidence& point : points) {
    const HeldOutErrors errors = hold_out(point, normal, basis);
    const std::vector<double> common = common_errors(errors.group, errors.relative);
    point_errors.push_back(std::sqrt(mean(clipped_squares(errors.relative, errors.rows, common))));
    local_errors.push_back(lower_quantile(common, 1));
    const auto squares =
        clipped_squares(errors.stated, errors.rows, common_errors(errors.group, errors.stated));
    candidate.squared.insert(candidate.squared.end(), squares.begin(), squares.end());
  }
  candidate.heldout_error = lower_quantile(point_errors, 0.95);
  candidate.local_error = lower_quantile(local_errors, 0.95);
  candidate.mean_square = mean(candidate.squared);
  return candidate;
}

// True where a candidate predicts held-out rows within the tolerance, and no three neighbouring
// abscissae share an error of more than one and a half of it.
bool meets(const BasisCandidate& candidate, double tolerance) {
  return candidate.heldout_error <= tolerance && candidate.local_error <= kLocalShare * tolerance;
}

// True where a candidate's local error exceeds the best one's, and the tolerance, by less than
// half: the rest is noise, of which more pieces leave as much.
bool is_as_good_locally(const BasisCandidate& candidate, const BasisCandidate& best,
                        double tolerance) {
  return candidate.local_error <= kLocalShare * std::max(tolerance, best.local_error);
}

// True where a candidate is as good locally and its held-out errors exceed the best one's by no
// more than the tolerance or, row by row, their scatter, which is noise.
bool is_as_good(const BasisCandidate& candidate, const BasisCandidate& best, double tolerance) {
  if (!is_as_good_locally(candidate, best, tolerance)) return false;
  const double worse = candidate.mean_square - best.mean_square;
  return worse <= tolerance * tolerance || worse <= error_of_difference(candidate, best);
}

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

// Knots at equal shares of the density, half of which is even.
CurveBasis curvature_basis(int degree, int pieces, double range,
                           const std::vector<double>& density) {
  double total = 0;
  for (const double d : density) total += d;
  std::vector<double> share(kGrid + 1, 0.0);
  for (int i = 0; i < kGrid; ++i) {
    const double curvature = total > 0 ? density[i] / total : 1.0 / kGrid;
    share[i + 1] = share[i] + 0.5 * curvature + 0.5 / kGrid;
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

// The first candidate within the tolerance, or else as good as the best, where more pieces do not
// lower what neighbouring rows are off together.
std::size_t fewest(const std::vector<BasisCandidate>& candidates, std::size_t best,
                   double tolerance) {
  if (meets(candidates.back(), tolerance)) best = candidates.size() - 1;
  for (std::size_t i = 0; i < candidates.size(); ++i)
    if (candidates[i].heldout_error <= tolerance &&
        is_as_good_locally(candidates[i], candidates[best], tolerance))
      return i;
  for (std::size_t i = 0; i < best; ++i)
    if (is_as_good(candidates[i], candidates[best], tolerance)) return i;
  return best;
}

std::string reason_for(const BasisCandidate& chosen, bool is_wanted, double tolerance) {
  const std::string held_out = "held-out error of " + percent(chosen.heldout_error);
  if (is_wanted) return "pieces as asked, the better placement of their knots";
  if (meets(chosen, tolerance)) return "fewest pieces whose " + held_out + " meets the tolerance";
  if (chosen.heldout_error <= tolerance)
    return held_out + " meets the tolerance; what neighbouring rows are off together, up to " +
           percent(chosen.local_error) + ", more pieces hardly lower";
  return held_out +
         " is above the tolerance, but more pieces hardly lower it: rows scatter, or the force "
         "depends on more than this deflection";
}

// The basis of one kind from its rows at the points that can hold some out; of min_pieces
// or more where rows can carry them.
BasisReport search(const std::vector<PointEvidence>& points, const CurveBasis& normal, int wanted,
                   int min_pieces, double range, const FitOptions& options) {
  BasisReport report;
  std::vector<double> groups;
  for (const PointEvidence& point : points) groups.push_back(point.rows.back().group + 1);
  const int parameters = int(0.8 * median(groups));  // that a training fold can carry
  const int most = std::clamp(parameters - options.degree + 1, 1, 12);
  const std::vector<double> density =
      curvature_density(points, even_basis(options.degree, std::min(most, 8), range));
  const auto better_placement = [&](int pieces) {
    BasisCandidate even = judge(points, normal, even_basis(options.degree, pieces, range));
    if (pieces == 1) return even;
    BasisCandidate other =
        judge(points, normal, curvature_basis(options.degree, pieces, range, density));
    return other.mean_square < even.mean_square ? other : even;
  };

  std::vector<BasisCandidate> candidates;  // the best placement for each number of pieces
  std::size_t best = 0;
  for (int pieces = wanted > 0 ? wanted : std::min(min_pieces, most);
       pieces <= std::max(most, wanted); pieces += pieces < 6 ? 1 : 2) {
    candidates.push_back(better_placement(pieces));
    if (candidates.back().mean_square < candidates[best].mean_square) best = candidates.size() - 1;
    if (wanted > 0 || meets(candidates.back(), options.tolerance)) break;
    if (candidates.size() > best + 4) break;  // four in a row that do not help
  }

  const std::size_t chosen = fewest(candidates, best, options.tolerance);
  report.basis = candidates[chosen].basis;
  report.heldout_error = candidates[chosen].heldout_error;
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
    // A drag over a curved surface wanders a fiftieth in depth; fewer than four abscissae hold
    // nothing out.
    if (group_by_abscissa(rows[p].curve[kind], range, kind == 2 ? 0.02 : kSameAbscissa) >= 4)
      able.push_back(p);
  std::vector<PointEvidence> out;
  for (const std::size_t p : evenly(able, 64)) {
    PointEvidence point{unit_weights(rows[p].curve[kind]), 0, 0, {}};
    for (const CurveRow& row : point.rows) point.largest = std::max(point.largest, row.f);
    if (!(point.largest > 0)) continue;
    if (kind == static_cast<int>(CurveKind::limit)) {
      point.normal = fit_smooth(normal, unit_weights(rows[p].curve[0]));
      point.friction = median_ratio(point.rows, normal, point.normal);
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
  // The curvature of one cubic, which is the bed, is a line, and that of a ball on a half-space
  // falls like 1/sqrt(d): two pieces at least.
  BasisReport report = search(points, {}, 0, 2, 1.0, exact);
  report.reason = "its curvature is the bed: pieces whose held-out error of presses, " +
                  percent(report.heldout_error, 2) + ", more hardly lower";
  return report;
}

}  // namespace palpate::fit
