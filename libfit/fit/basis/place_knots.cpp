#include "libfit/fit/basis/place_knots.hpp"

#include <ceres/tiny_solver.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate::fit {
namespace {

constexpr std::size_t kMaxPoints = 24;
constexpr double kMinShare = 0.02;    // of the range
constexpr double kRowsOfPiece = 2;    // of a typical point, in the shortest piece
constexpr double kWidestLeast = 0.5;  // of even pieces: knots keep room to move
constexpr int kFoldIterations = 8;    // from knots that have settled on all rows
constexpr double kWorthTrying = 0.9;  // of the residuals of knots placed by rule

// Points without the rows of a fold.
std::vector<PointEvidence> without_fold(std::vector<PointEvidence> points, int fold) {
  for (PointEvidence& point : points) {
    std::vector<CurveRow> seen;
    for (const CurveRow& row : point.rows)
      if (!is_held_out(point, row, fold)) seen.push_back(row);
    point.rows = std::move(seen);
  }
  return points;
}

// Knots whose every spacing exceeds `least` by some of what even pieces have.
std::vector<double> apart(const std::vector<double>& knots, double least) {
  constexpr double kEven = 0.05;
  const double range = knots.back();
  const auto pieces = static_cast<double>(knots.size() - 1);
  double room = 0;
  std::vector<double> over;
  for (std::size_t i = 1; i < knots.size(); ++i) {
    over.push_back(std::max(knots[i] - knots[i - 1] - least, kEven * (range / pieces - least)));
    room += over.back();
  }
  std::vector<double> out{0.0};
  for (const double h : over)
    out.push_back(out.back() + least + (range - least * pieces) * h / room);
  out.back() = range;
  return out;
}

}  // namespace

double min_spacing(const std::vector<PointEvidence>& points, double range, int pieces) {
  std::vector<double> gaps;
  for (const PointEvidence& point : points) gaps.push_back(range / (point.rows.back().group + 1));
  return std::min(std::max(kMinShare * range, kRowsOfPiece * median(gaps)),
                  kWidestLeast * range / pieces);
}

PlacedKnots place_knots(const std::vector<PointEvidence>& all, const CurveBasis& start,
                        const CurveBasis& reference, FitLoss loss, int max_iterations) {
  const std::vector<PointEvidence> points = evenly(all, kMaxPoints);
  const int pieces = start.pieces();
  const double least = min_spacing(points, start.knots_m.back(), pieces);
  KnotResiduals function(points, reference, pieces, least, loss);
  Eigen::VectorXd ratios = log_ratios(apart(start.knots_m, least), least);
  Eigen::VectorXd left(function.NumResiduals());
  PlacedKnots placed{start, 0, 0, 0};
  if (pieces < 2 || left.size() == 0) return placed;
  function(ratios.data(), left.data(), nullptr);
  const double size = left.norm(), rows = std::sqrt(static_cast<double>(left.size()));
  placed.rms_start = placed.rms = size / rows;
  if (!(size > 0)) return placed;
  function.scale(1 / size);
  ceres::TinySolver<KnotResiduals> solver;
  solver.options.max_num_iterations = max_iterations;
  solver.options.function_tolerance = 1e-7;  // absolute, of a cost that begins at 1/2
  solver.options.cost_threshold = 1e-14;
  const auto summary = solver.Solve(function, &ratios);
  placed.basis = function.basis(ratios);
  placed.rms = std::sqrt(2 * summary.final_cost) * size / rows;
  placed.iterations = summary.iterations;
  return placed;
}

std::optional<BasisCandidate> identified_candidate(const std::vector<PointEvidence>& points,
                                                   const CurveBasis& normal,
                                                   const std::vector<CurveBasis>& starts,
                                                   const CurveBasis& reference, FitLoss loss) {
  PlacedKnots best;
  double by_rule = std::numeric_limits<double>::infinity();
  for (const CurveBasis& start : starts) {
    PlacedKnots found = place_knots(points, start, reference, loss);
    by_rule = std::min(by_rule, found.rms_start);
    if (best.basis.knots_m.empty() || found.rms < best.rms) best = std::move(found);
  }
  if (!(best.rms < kWorthTrying * by_rule)) return std::nullopt;
  std::vector<CurveBasis> of_fold;
  for (int fold = 0; fold < kFolds; ++fold)
    of_fold.push_back(
        place_knots(without_fold(points, fold), best.basis, reference, loss, kFoldIterations)
            .basis);
  return judge(points, normal, best.basis, KnotPlacement::identified, loss, of_fold);
}

}  // namespace palpate::fit
