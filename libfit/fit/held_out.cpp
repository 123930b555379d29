#include "libfit/fit/held_out.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::fit {
namespace {

constexpr int kFolds = 5;
constexpr double kRelativeFloor = 0.1;  // of the largest force: below it errors count absolutely

// The knowledge that fills gaps: a limit curve is shaped like f^z, others are smooth.
Faint faint_for(const PointEvidence& point, const CurveBasis& normal, const CurveBasis& basis) {
  if (point.normal.size() == 0) return faint_smoothness(basis);
  return faint_pull(transfer(normal, point.normal, basis, point.friction));
}

// Errors of rows, each predicted by a fit that left its fold out. Only interpolation is judged: the
// deepest group is always seen, and of a limit curve the shallowest too.
struct HeldOut {
  std::vector<double> relative;  // sizes over the row's force
  std::vector<double> weighted;  // sizes over the point's rms force, both weighted
};
HeldOut hold_out(const PointEvidence& point, const CurveBasis& normal,
                 const CurveBasis& basis, FitLoss loss) {
  const SplineTables tables = tabulate(basis);
  const auto spline = view(tables);
  const Faint faint = faint_for(point, normal, basis);
  const Eigen::VectorXd lower = Eigen::VectorXd::Zero(basis.size() - 1);
  const int first = point.normal.size() > 0 ? 0 : -1, last = point.rows.back().group;
  double force_square = 0;
  for (const CurveRow& row : point.rows) force_square += std::pow(row.weight * row.f, 2);
  const double rms = std::sqrt(force_square / static_cast<double>(point.rows.size()));
  HeldOut errors;
  for (int fold = 0; fold < kFolds; ++fold) {
    std::vector<CurveRow> seen, unseen;
    for (const CurveRow& row : point.rows)
      (row.group % kFolds == fold && row.group != first && row.group != last ? unseen : seen)
          .push_back(row);
    if (unseen.empty()) continue;
    const Eigen::VectorXd increments = fit_increments(spline, seen, lower, Faint(faint), loss);
    for (const CurveRow& row : unseen) {
      const double size = std::abs(increment_weights(spline, row.x).dot(increments) - row.f);
      errors.relative.push_back(size /
                                std::max(std::abs(row.f), kRelativeFloor * point.largest));
      errors.weighted.push_back(size * row.weight / rms);
    }
  }
  return errors;
}

// Squares of sizes, those of outliers clipped.
std::vector<double> clipped_squares(std::vector<double> sizes, FitLoss loss) {
  const double clip = 4 * robust_deviation(sizes);
  for (double& size : sizes) {
    if (loss != FitLoss::squared && clip > 0) size = std::min(size, clip);
    size *= size;
  }
  return sizes;
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return values.empty() ? 0 : sum / static_cast<double>(values.size());
}

}  // namespace

std::vector<CurveRow> unit_weights(std::vector<CurveRow> rows) {
  double sum = 0;
  for (const CurveRow& row : rows) sum += row.weight * row.weight;
  const double scale = sum > 0 ? std::sqrt(static_cast<double>(rows.size()) / sum) : 1;
  for (CurveRow& row : rows) row.weight *= scale;
  return rows;
}

Eigen::VectorXd transfer(const CurveBasis& from, const Eigen::VectorXd& increments,
                         const CurveBasis& to, double factor) {
  if (from.degree == to.degree && from.knots_m == to.knots_m) return factor * increments;
  const SplineTables source = tabulate(from), target = tabulate(to);
  std::vector<CurveRow> rows;
  const int count = 6 * to.size();
  for (int i = 1; i <= count; ++i) {
    const double x = to.knots_m.back() * i / count;
    rows.push_back({x, factor * increment_weights(view(source), x).dot(increments), 1, 0});
  }
  Faint faint = faint_smoothness(to);
  faint.per_noise = 0;
  return fit_increments(view(target), rows, Eigen::VectorXd::Zero(to.size() - 1), faint,
                        FitLoss::squared);
}

Candidate judge(const std::vector<PointEvidence>& points, const CurveBasis& normal,
                const CurveBasis& basis, bool by_curvature, FitLoss loss) {
  Candidate candidate{{basis.pieces(), by_curvature, 0}, basis, {}, 0};
  std::vector<double> point_errors;
  for (const PointEvidence& point : points) {
    HeldOut errors = hold_out(point, normal, basis, loss);
    point_errors.push_back(std::sqrt(mean(clipped_squares(std::move(errors.relative), loss))));
    const auto squares = clipped_squares(std::move(errors.weighted), loss);
    candidate.squared.insert(candidate.squared.end(), squares.begin(), squares.end());
  }
  candidate.evidence.heldout_error = quantile(point_errors, 0.95);
  candidate.mean_square = mean(candidate.squared);
  return candidate;
}

bool is_as_good(const Candidate& candidate, const Candidate& best, double tolerance) {
  const auto n = static_cast<double>(best.squared.size());
  const double worse = candidate.mean_square - best.mean_square;
  if (worse <= tolerance * tolerance) return true;
  double square = 0;
  for (std::size_t i = 0; i < best.squared.size(); ++i)
    square += std::pow(candidate.squared[i] - best.squared[i] - worse, 2);
  return worse <= std::sqrt(square) / n;
}

}  // namespace palpate::fit
