#include "libfit/fit/neighbours/smooth_curves.hpp"

#include <algorithm>
#include <cmath>

#include "libfit/core/error.hpp"
#include "libfit/fit/fit_options.hpp"
#include "libfit/fit/neighbours/choose_smoothing.hpp"
#include "libfit/fit/spline/curve_band.hpp"
#include "libfit/fit/words.hpp"

namespace palpate::fit {
namespace {

constexpr double kTolerance = 1e-12;
constexpr double kMostlyOwn = 0.9;
constexpr double kMinSlope = 0.1;  // of the typical slope: where curves are flat, in a toe
constexpr double kSameAbscissa = 1e-3, kSameDepth = 0.02;  // of the range, as in choose_basis.cpp

// The points that take part, and where each is among them (-1: nowhere).
struct Members {
  std::vector<Eigen::Index> point;
  std::vector<std::int32_t> place;
};

Members members_of(const FittedCurves& fitted, std::size_t kind) {
  Members out;
  for (std::size_t p = 0; p < fitted.status.size(); ++p) {
    const auto at = static_cast<Eigen::Index>(p);
    const bool takes_part =
        fitted.status[p] != FitStatus::failed && fitted.covariance[kind].row(at).allFinite();
    out.place.push_back(takes_part ? static_cast<std::int32_t>(out.point.size()) : -1);
    if (takes_part) out.point.push_back(at);
  }
  return out;
}

std::vector<PointEdge> edges_among(const Members& members, const FittedCurves& fitted,
                                   const Triangles& triangles) {
  std::vector<char> takes_part;
  for (const std::int32_t place : members.place) takes_part.push_back(place >= 0);
  auto edges = point_graph(fitted.position, fitted.normal, takes_part, triangles);
  for (PointEdge& e : edges) {
    e.first = members.place[static_cast<std::size_t>(e.first)];
    e.second = members.place[static_cast<std::size_t>(e.second)];
  }
  return edges;
}

// The body's typical increments [N]: the median slope of its curves, a share of the whole curve's
// at least, over the steps of a curve of slope 1.
Eigen::VectorXd typical_increments(const Controls& increments, const CurveBasis& basis_m) {
  const Eigen::VectorXd steps = greville_steps(basis_m);
  const auto median_of = [](const Eigen::VectorXd& values) {
    return median({values.data(), values.data() + values.size()});
  };
  const double whole = median_of(increments.rowwise().sum()) / steps.sum();
  Eigen::VectorXd typical(steps.size());
  for (Eigen::Index j = 0; j < steps.size(); ++j)
    typical[j] = steps[j] * std::max(median_of(increments.col(j)) / steps[j], kMinSlope * whole);
  return typical;
}

Eigen::MatrixXd unpack_symmetric(const Eigen::VectorXd& packed, Eigen::Index n) {
  Eigen::MatrixXd matrix(n, n);
  Eigen::Index at = 0;
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) matrix(i, j) = matrix(j, i) = packed[at++];
  return matrix;
}

// Without dimension, as choose_smoothing wants it, rows only where the strength is to be chosen;
// `typical` [N] is what it was divided by.
SmoothingData gather(const FittedCurves& fitted, const BodyData& body,
                     const std::vector<PointRows>& rows, const BodyBases& bases,
                     const Members& members, std::size_t kind, bool is_chosen,
                     Eigen::VectorXd& typical) {
  const auto count = static_cast<Eigen::Index>(members.point.size());
  const Eigen::Index n = bases.si[kind].size() - 1;
  SmoothingData data{bases.plain[kind], Controls(count, n), {}, {}, {}, Controls(count, n)};
  for (Eigen::Index i = 0; i < count; ++i)
    data.estimate.row(i) =
        increments_of(fitted.curves.control[kind].row(members.point[static_cast<std::size_t>(i)]));
  typical = typical_increments(data.estimate, bases.si[kind]);
  if (!(typical.minCoeff() > 0)) return data;
  data.estimate *= typical.cwiseInverse().asDiagonal();
  const Eigen::VectorXd inverse = typical.cwiseInverse();
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Index p = members.point[static_cast<std::size_t>(i)];
    data.covariance.push_back(inverse.asDiagonal() *
                              unpack_symmetric(fitted.covariance[kind].row(p), n) *
                              inverse.asDiagonal());
    if (!is_chosen) continue;
    data.unit.row(i) = typical / body.points[static_cast<std::size_t>(p)].force_N;
    data.rows.push_back(unit_weights(rows[static_cast<std::size_t>(p)].curve[kind]));
    group_by_abscissa(data.rows.back(), data.basis.knots_m.back(),
                      kind == 2 ? kSameDepth : kSameAbscissa);
  }
  return data;
}

// Puts the field's minimum and its covariance in place of the points' own.
void replace_curves(const SmoothingData& data, const Members& members,
                    const Eigen::VectorXd& typical, std::size_t kind, FittedCurves& fitted,
                    SmoothingReport& report) {
  const GraphQuadratic field = make_quadratic(data.estimate, data.covariance, data.edges);
  const Controls smooth = bounded_minimum(field, report.strength, field.centre, kTolerance);
  const auto covariance = posterior_covariance(field, report.strength);
  std::vector<char> has_neighbour(members.point.size(), 0);
  for (const PointEdge& e : data.edges)
    has_neighbour[static_cast<std::size_t>(e.first)] =
        has_neighbour[static_cast<std::size_t>(e.second)] = 1;
  fitted.own.control[kind] = fitted.curves.control[kind];
  fitted.own.covariance[kind] = fitted.covariance[kind];
  std::vector<double> moves;
  for (std::size_t i = 0; i < members.point.size(); ++i) {
    if (!has_neighbour[i]) continue;
    const auto at = static_cast<Eigen::Index>(i), p = members.point[i];
    const Eigen::VectorXd u = smooth.row(at), way = u - field.centre.row(at).transpose();
    fitted.curves.control[kind].row(p) = stored_controls(u.cwiseProduct(typical), 1, kind == 1);
    const Eigen::MatrixXd left = covariance[i] + (1 - field.own_share) * data.covariance[i];
    fitted.covariance[kind].row(p) =
        pack_symmetric(typical.asDiagonal() * left * typical.asDiagonal());
    moves.push_back(std::sqrt(field.own_share * way.dot(field.precision[i] * way) /
                              static_cast<double>(way.size())));
    if (report.largest_point < 0 || moves.back() > report.largest_move)
      report.largest_move = moves.back(), report.largest_point = p;
  }
  report.median_move = median(std::move(moves));
  if (field.own_share < kMostlyOwn)
    report.reason += ", but " + percent(1 - field.own_share) +
                     " of their variance is common to neighbours and stays";
}

SmoothingReport smooth_kind(const BodyData& body, const std::vector<PointRows>& rows,
                            const BodyBases& bases, const FitOptions& options, std::size_t kind,
                            FittedCurves& fitted) {
  SmoothingReport report;
  const Members members = members_of(fitted, kind);
  report.points = static_cast<Eigen::Index>(members.point.size());
  if (report.points < 2) {
    report.reason = "no two points have a band of their own";
    return report;
  }
  const auto kept = kept_strengths(options);
  Eigen::VectorXd typical;
  SmoothingData data =
      gather(fitted, body, rows, bases, members, kind, !kept && !options.smoothing, typical);
  if (!(typical.minCoeff() > 0)) {
    report.reason = "most curves are zero";
    return report;
  }
  data.edges = edges_among(members, fitted, options.triangles);
  report.neighbours = static_cast<Eigen::Index>(data.edges.size());
  if (kept) {
    report.strength = data.edges.empty() ? 0 : (*kept)[kind];
    report.reason = options.warm_start->smoothing_reason[kind];
  } else if (options.smoothing) {
    report.strength = data.edges.empty() ? 0 : *options.smoothing;
    report.reason = "as asked";
  } else {
    choose_smoothing(data, options.loss, report);
  }
  if (report.strength > 0) replace_curves(data, members, typical, kind, fitted, report);
  return report;
}

// Whether a kept point has the curves that its stored score is of.
bool has_earlier_curves(const FittedCurves& fitted, const FitOptions& options, Eigen::Index p,
                        const PointResult& result) {
  bool is_same = result.is_kept;
  for (std::size_t kind = 0; kind < curves_of(fitted.curves.family) && is_same; ++kind)
    is_same = fitted.curves.control[kind].row(p) ==
              options.warm_start->curves.control[kind].row(result.earlier_row);
  return is_same;
}

void score_points(const Samples& samples, const BodyData& body, const BodyBases& bases,
                  const std::vector<char>& is_wanted, FittedCurves& fitted,
                  std::vector<PointResult>& results) {
  const Bases si = si_bases(bases);
  for (std::size_t p = 0; p < results.size(); ++p) {
    if (!is_wanted[p]) continue;
    PointResult& result = results[p];
    result.score =
        score_point(samples, body.points[p], body.length_m, si, result.control, result.sensor);
    fitted.rms_residual_N[static_cast<Eigen::Index>(p)] = result.score.rms_N;
    fitted.max_residual_N[static_cast<Eigen::Index>(p)] = result.score.max_N;
  }
}

void score_again(const Samples& samples, const BodyData& body, const BodyBases& bases,
                 const FitOptions& options, const ReadRows& read_rows, FittedCurves& fitted,
                 std::vector<PointResult>& results) {
  std::vector<char> is_here(results.size(), 0), is_elsewhere(results.size(), 0);
  for (std::size_t p = 0; p < results.size(); ++p) {
    const auto at = static_cast<Eigen::Index>(p);
    for (std::size_t kind = 0; kind < curves_of(bases.family); ++kind)
      results[p].control[kind] = fitted.curves.control[kind].row(at);
    if (!results[p].is_scored || has_earlier_curves(fitted, options, at, results[p])) continue;
    (body.points[p].experiments.empty() ? is_elsewhere : is_here)[p] = 1;
  }
  score_points(samples, body, bases, is_here, fitted, results);
  if (std::find(is_elsewhere.begin(), is_elsewhere.end(), 1) == is_elsewhere.end()) return;
  const Samples more = read_rows(is_elsewhere);
  score_points(more, gather_experiments(more, options.weight_floor, body.length_m), bases,
               is_elsewhere, fitted, results);
}

}  // namespace

std::array<SmoothingReport, kCurveKinds> smooth_curves(
    const Samples& samples, const BodyData& body, const std::vector<PointRows>& rows,
    const BodyBases& bases, const FitOptions& options, FittedCurves& fitted,
    std::vector<PointResult>& results, const ReadRows& read_rows) {
  if (options.triangles.rows() > 0 &&
      (options.triangles.minCoeff() < 0 || options.triangles.maxCoeff() >= fitted.position.rows()))
    throw Error("fit option triangles", "names a point that is not there",
                "Give the triangles of these test points, or none.");
  std::array<SmoothingReport, kCurveKinds> reports;
  const FittedCurves* earlier = options.warm_start;
  const auto kept = kept_strengths(options);
  bool is_changed = false;
  for (const double strength : earlier != nullptr ? earlier->smoothing : fitted.smoothing)
    is_changed = is_changed || strength > 0;  // kept scores are of smoothed curves
  for (std::size_t kind = 0; kind < curves_of(bases.family); ++kind) {
    if (options.smoothing == 0.0) {
      reports[kind].reason = "as asked";
      continue;
    }
    if (kept && (*kept)[kind] == 0) {
      reports[kind].reason = fitted.smoothing_reason[kind] = earlier->smoothing_reason[kind];
      continue;
    }
    reports[kind] = smooth_kind(body, rows, bases, options, kind, fitted);
    fitted.smoothing[kind] = reports[kind].strength;
    fitted.smoothing_reason[kind] = reports[kind].reason;
    is_changed = is_changed || reports[kind].strength > 0;
  }
  if (is_changed) score_again(samples, body, bases, options, read_rows, fitted, results);
  return reports;
}

}  // namespace palpate::fit
