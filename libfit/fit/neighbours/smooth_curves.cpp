#include "libfit/fit/neighbours/smooth_curves.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"
#include "libfit/fit/neighbours/choose_smoothing.hpp"
#include "libfit/fit/spline/curve_band.hpp"

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
                     const std::vector<CurveRows>& rows, const BodyBases& bases,
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
  std::vector<double> moves;
  for (std::size_t i = 0; i < members.point.size(); ++i) {
    if (!has_neighbour[i]) continue;
    const auto at = static_cast<Eigen::Index>(i), p = members.point[i];
    const Eigen::VectorXd u = smooth.row(at), move = u - field.centre.row(at).transpose();
    fitted.curves.control[kind].row(p) = stored_controls(u.cwiseProduct(typical), 1, kind == 1);
    const Eigen::MatrixXd left = covariance[i] + (1 - field.own_share) * data.covariance[i];
    fitted.covariance[kind].row(p) =
        pack_symmetric(typical.asDiagonal() * left * typical.asDiagonal());
    moves.push_back(std::sqrt(field.own_share * move.dot(field.precision[i] * move) /
                              static_cast<double>(move.size())));
    if (report.largest_point < 0 || moves.back() > report.largest_move)
      report.largest_move = moves.back(), report.largest_point = p;
  }
  report.median_move = median(std::move(moves));
  if (field.own_share < kMostlyOwn)
    report.reason += ", but " + percent(1 - field.own_share) +
                     " of their variance is common to neighbours and stays";
}

// Strengths that a warm start keeps: those that the earlier fit chose, where none is asked for.
std::optional<std::array<double, kCurveKinds>> kept_strengths(const FitOptions& options) {
  const FittedCurves* earlier = options.warm_start;
  if (earlier == nullptr || options.smoothing || earlier->smoothing_reason[0].empty())
    return std::nullopt;
  return earlier->smoothing;
}

SmoothingReport smooth_kind(const BodyData& body, const std::vector<CurveRows>& rows,
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

}  // namespace

Smoothing smooth_curves(const BodyData& body, const std::vector<CurveRows>& rows,
                        const BodyBases& bases, const FitOptions& options, FittedCurves& fitted) {
  if (options.triangles.rows() > 0 &&
      (options.triangles.minCoeff() < 0 || options.triangles.maxCoeff() >= fitted.position.rows()))
    throw Error("fit option triangles", "names a point that is not there",
                "Give the triangles of these test points, or none.");
  Smoothing out;
  const auto kept = kept_strengths(options);
  for (std::size_t kind = 0; kind < curves_of(bases.family); ++kind) {
    SmoothingReport& report = out.report[kind];
    if (options.smoothing == 0.0) {
      report.reason = "as asked";
      continue;
    }
    if (kept && (*kept)[kind] == 0) {
      report.reason = fitted.smoothing_reason[kind] = options.warm_start->smoothing_reason[kind];
      continue;
    }
    const Controls control = fitted.curves.control[kind], covariance = fitted.covariance[kind];
    report = smooth_kind(body, rows, bases, options, kind, fitted);
    fitted.smoothing[kind] = report.strength;
    fitted.smoothing_reason[kind] = report.reason;
    if (report.strength > 0) out.own_control[kind] = control, out.own_covariance[kind] = covariance;
  }
  return out;
}

}  // namespace palpate::fit
