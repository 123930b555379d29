#include "libfit/fit/warm_start.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "libfit/core/fast_hash.hpp"
#include "libfit/fit/point/nuisance.hpp"

namespace palpate::fit {
namespace {

constexpr double kErrorUnit = 1e-6;

std::uint64_t mix_number(std::uint64_t hash, double value) {
  return mix_word(hash, std::bit_cast<std::uint64_t>(value));
}

std::int32_t in_millionths(double error) {
  constexpr double most = std::numeric_limits<std::int32_t>::max();
  return static_cast<std::int32_t>(std::lround(std::min(error / kErrorUnit, most)));
}

}  // namespace

std::vector<std::string> point_hashes(const Samples& points, const RowIndex& index,
                                      const FitOptions& options) {
  std::vector<std::string> hashes;
  std::uint64_t common = 0;
  for (const double value :
       {static_cast<double>(options.loss), options.poor_above, options.weight_floor,
        options.default_friction, options.default_lateral_ratio})
    common = mix_number(common, value);
  for (Eigen::Index p = 0; p < points.points(); ++p) {
    std::uint64_t hash = fast_hash(index.hash[static_cast<std::size_t>(p)], common);
    for (int k = 0; k < 3; ++k) hash = mix_number(hash, points.point_position(p, k));
    for (int k = 0; k < 3; ++k) hash = mix_number(hash, points.point_normal(p, k));
    if (points.point_normal_gradient.rows() > 0)
      for (int k = 0; k < 9; ++k) hash = mix_number(hash, points.point_normal_gradient(p, k));
    hashes.push_back(hex16(hash));
  }
  return hashes;
}

void add_borrowed(const BodyData& body, std::vector<std::string>& hashes) {
  for (std::size_t p = 0; p < hashes.size(); ++p) {
    const PointData& point = body.points[p];
    std::uint64_t hash = 0;
    if (!point.has_errors && body.error_N > 0 && point.problem.empty())
      hash = mix_number(hash, body.error_N);
    for (const Experiment& e : point.experiments)
      for (const double d : {e.unknown.contact * body.length_m, e.unknown.bias * point.force_N,
                             e.unknown.drift * point.force_N})
        if (d > 0) hash = mix_number(hash, d);
    if (hash != 0) hashes[p] = hex16(fast_hash(hashes[p], hash));
  }
}

EarlierPoints::EarlierPoints(const FittedCurves* earlier) {
  if (earlier == nullptr || earlier->scores.empty() || earlier->rows_hash.empty() ||
      earlier->covariance[0].size() == 0)
    return;
  earlier_ = earlier;
  first_error_.push_back(0);
  for (Eigen::Index p = 0; p < earlier->scores.rows.rows(); ++p)
    first_error_.push_back(first_error_.back() +
                           (std::isnan(earlier->scores.relative_residual[p])
                                ? 0
                                : static_cast<std::size_t>(earlier->scores.rows(p, 0))));
}

std::vector<Eigen::Index> EarlierPoints::rows_of(const std::vector<std::string>& hashes) const {
  std::vector<Eigen::Index> out(hashes.size(), -1);
  if (earlier_ == nullptr) return out;
  const auto& known = earlier_->rows_hash;
  std::unordered_map<std::string_view, Eigen::Index> row;
  for (std::size_t p = 0; p < hashes.size(); ++p) {
    if (p < known.size() && known[p] == hashes[p]) {  // as a rule, points keep their places
      out[p] = static_cast<Eigen::Index>(p);
      continue;
    }
    if (row.empty())
      for (std::size_t k = 0; k < known.size(); ++k)
        row.emplace(known[k], static_cast<Eigen::Index>(k));
    const auto found = row.find(hashes[p]);
    if (found != row.end()) out[p] = found->second;
  }
  return out;
}

PointResult EarlierPoints::keep(Eigen::Index row, std::int32_t first_experiment,
                                std::size_t experiments) const {
  const auto at = static_cast<std::size_t>(row);
  const FitScores& scores = earlier_->scores;
  PointResult result;
  for (const Controls& control : earlier_->curves.control)
    result.control.emplace_back(control.row(row));
  for (std::size_t kind = 0; kind < curves_of(earlier_->curves.family); ++kind) {
    const bool is_smoothed = earlier_->own.control[kind].rows() > 0;
    result.control[kind] =
        (is_smoothed ? earlier_->own.control[kind] : earlier_->curves.control[kind]).row(row);
    result.covariance[kind] =
        (is_smoothed ? earlier_->own.covariance : earlier_->covariance)[kind].row(row);
  }
  result.status = earlier_->status[at];
  result.message = earlier_->message[at];
  result.is_kept = true;
  result.earlier_row = row;
  restore_sensors(earlier_->recordings, row, experiments, result);
  result.depth_m = earlier_->depth_range_m[row];
  result.curve_end_m = scores.curve_end_m.row(row);
  result.states_errors = scores.states_errors[at] != 0;
  result.rows = {scores.rows(row, 0), scores.rows(row, 1), scores.rows(row, 2),
                 scores.rows(row, 3)};
  result.is_scored = !std::isnan(scores.relative_residual[row]);
  if (!result.is_scored) return result;
  result.score.rms_N = earlier_->rms_residual_N[row];
  result.score.max_N = earlier_->max_residual_N[row];
  result.score.relative = scores.relative_residual[row];
  result.score.worst_experiment = first_experiment + scores.worst_experiment[at];
  result.score.worst_row = static_cast<std::size_t>(scores.worst_row[at]);
  for (std::size_t i = first_error_[at]; i < first_error_[at + 1]; ++i)
    result.score.relative_errors.push_back(kErrorUnit * scores.relative_error[i]);
  return result;
}

double EarlierPoints::depth_m(const std::vector<Eigen::Index>& kept) const {
  double depth = 0;
  for (const Eigen::Index row : kept)
    if (row >= 0) depth = std::max(depth, earlier_->depth_range_m[row]);
  return depth;
}

bool EarlierPoints::are_errors_alike(const std::vector<Eigen::Index>& kept,
                                     const BodyData& body) const {
  bool is_any = false, is_all = true;
  for (std::size_t p = 0; p < kept.size(); ++p) {
    const bool is_kept = kept[p] >= 0;
    if ((is_kept ? earlier_->scores.rows(kept[p], 0) : body.points[p].rows.used) == 0) continue;
    const bool states = is_kept
                            ? earlier_->scores.states_errors[static_cast<std::size_t>(kept[p])] != 0
                            : body.points[p].has_errors;
    is_any |= states, is_all &= states;
  }
  return is_all || !is_any;
}

FitScores collect_scores(const RowIndex& index, const std::vector<PointResult>& results) {
  const auto points = static_cast<Eigen::Index>(results.size());
  FitScores out;
  out.relative_residual.setConstant(points, std::numeric_limits<double>::quiet_NaN());
  out.worst_experiment.assign(results.size(), 0), out.worst_row.assign(results.size(), 0);
  out.rows.resize(points, 4), out.curve_end_m.resize(points, 3);
  for (std::size_t p = 0; p < results.size(); ++p) {
    const PointResult& result = results[p];
    const auto row = static_cast<Eigen::Index>(p);
    out.rows.row(row) << result.rows.used, result.rows.not_good, result.rows.not_finite,
        result.rows.cut;
    out.curve_end_m.row(row) = result.curve_end_m;
    out.states_errors.push_back(result.states_errors);
    if (!result.is_scored || std::isnan(result.score.relative)) continue;
    out.relative_residual[row] = result.score.relative;
    out.worst_experiment[p] = result.score.worst_experiment - index.first_experiment[p];
    out.worst_row[p] = static_cast<std::int32_t>(result.score.worst_row);
    for (const double error : result.score.relative_errors)
      out.relative_error.push_back(in_millionths(error));
  }
  return out;
}

}  // namespace palpate::fit
