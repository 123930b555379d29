#include "libfit/fit/rows/held_out.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "libfit/core/stated_error.hpp"
#include "libfit/core/statistics.hpp"

namespace palpate::fit {
namespace {

// The largest of many medians of three: noise of deviation 1 reaches 1.5 in one point of three.
constexpr double kLocalShare = 1.5;

// The knowledge that fills gaps: a limit curve is shaped like f^z, others are smooth.
WeakPrior prior_for(const PointEvidence& point, const CurveBasis& normal, const CurveBasis& basis) {
  if (point.normal.size() == 0) return smoothness_prior(basis);
  return value_prior(transfer(normal, point.normal, basis, point.friction));
}

constexpr int kFolds = 5;  // a point's abscissae are held out a fifth at a time

// Whether a fold holds the row out. Only interpolation is judged: the deepest group is never held
// out, and of a limit curve neither is the shallowest.
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
  std::vector<double> weighted;  // over the point's rms force, both weighted
};
HeldOutErrors hold_out(const PointEvidence& point, const CurveBasis& normal,
                       const CurveBasis& basis) {
  const SplineTables tables = tabulate(basis);
  double force_square = 0;
  for (const CurveRow& row : point.rows) force_square += std::pow(row.weight * row.f, 2);
  const double rms = std::sqrt(force_square / double(point.rows.size()));
  std::vector<double> error(point.rows.size(), std::numeric_limits<double>::quiet_NaN());
  for (int fold = 0; fold < kFolds; ++fold) {
    std::vector<CurveRow> seen;
    for (const CurveRow& row : point.rows)
      if (!is_held_out(point, row, fold)) seen.push_back(row);
    if (seen.size() == point.rows.size()) continue;
    const Eigen::VectorXd increments = fit_increments(
        basis, seen, Eigen::VectorXd::Zero(basis.size() - 1), prior_for(point, normal, basis));
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
    out.relative.push_back(
        relative_error(error[i], std::abs(row.f), relative_floor(point.largest)));
    out.weighted.push_back(error[i] * row.weight / rms);
  }
  return out;
}

// Of each row, the error that its abscissa has in common with its neighbours: the median of three
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

}  // namespace

BasisCandidate judge(const std::vector<PointEvidence>& points, const CurveBasis& normal,
                     const CurveBasis& basis, KnotPlacement placement) {
  BasisCandidate candidate{{basis.pieces(), placement, 0, 0}, basis, {}, 0};
  std::vector<double> point_errors, local_errors;
  for (const PointEvidence& point : points) {
    const HeldOutErrors errors = hold_out(point, normal, basis);
    const std::vector<double> common = common_errors(errors.group, errors.relative);
    point_errors.push_back(std::sqrt(mean(clipped_squares(errors.relative, errors.rows, common))));
    local_errors.push_back(lower_quantile(common, 1));
    const auto squares =
        clipped_squares(errors.weighted, errors.rows, common_errors(errors.group, errors.weighted));
    candidate.squared.insert(candidate.squared.end(), squares.begin(), squares.end());
  }
  candidate.evidence.heldout_error = lower_quantile(point_errors, 0.95);
  candidate.evidence.local_error = lower_quantile(local_errors, 0.95);
  candidate.mean_square = mean(candidate.squared);
  return candidate;
}

bool meets(const BasisCandidate& candidate, double tolerance) {
  return candidate.evidence.heldout_error <= tolerance &&
         candidate.evidence.local_error <= kLocalShare * tolerance;
}

bool is_as_good_locally(const BasisCandidate& candidate, const BasisCandidate& best,
                        double tolerance) {
  return candidate.evidence.local_error <=
         kLocalShare * std::max(tolerance, best.evidence.local_error);
}

bool is_as_good(const BasisCandidate& candidate, const BasisCandidate& best, double tolerance) {
  if (!is_as_good_locally(candidate, best, tolerance)) return false;
  const double worse = candidate.mean_square - best.mean_square;
  return worse <= tolerance * tolerance || worse <= error_of_difference(candidate, best);
}

}  // namespace palpate::fit
