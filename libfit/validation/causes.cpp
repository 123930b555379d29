#include "libfit/validation/causes.hpp"

#include <algorithm>

#include "libfit/core/stated_error.hpp"
#include "libfit/fit/fit_curves.hpp"
#include "libfit/validation/substitute.hpp"

namespace palpate::validation {
namespace {

// Curves of the held-out points from their own experiments, on given knots.
FittedCurves own_curves(const runtime::AssetView& asset, const Samples& own, int split, int jobs) {
  FitOptions options = options_for(own);
  options.family = static_cast<CurveFamily>(asset.curves.family);
  options.degree = asset.curves.view[0].degree;
  options.sways = asset.sways;
  for (std::size_t kind = 0; kind < curves_of(*options.family); ++kind) {
    const std::vector<double> knots = basis_of(asset, static_cast<int>(kind)).knots_m;
    for (std::size_t i = 0; i + 1 < knots.size(); ++i)
      for (int k = 0; k < split; ++k)
        options.knots_m[kind].push_back(knots[i] + (knots[i + 1] - knots[i]) * k / split);
    options.knots_m[kind].push_back(knots.back());
  }
  options.jobs = jobs;
  return fit_curves(own, options);
}

// Number in `own` of the place of each path; -1 where nothing else was done there.
std::vector<Eigen::Index> own_points(const Reference& reference) {
  std::vector<Eigen::Index> out;
  for (const auto& place : reference.paths.point_position.rowwise()) {
    Eigen::Index p = reference.own.points() - 1;
    while (p >= 0 && reference.own.point_position.row(p) != place) --p;
    out.push_back(p);
  }
  return out;
}

// Each path with the curves of its own point all over the surface, where it has some.
Replayed replay_with_own(const runtime::AssetView& asset, const Samples& paths,
                         const std::vector<Eigen::Index>& point_of, const FittedCurves& own,
                         double depth_m) {
  Replayed replayed(paths);
  for (Eigen::Index first = 0, last = 0; first < paths.rows(); first = last) {
    const std::int32_t path = paths.point[first];
    while (last < paths.rows() && paths.point[last] == path) ++last;
    if (point_of[path] < 0) continue;
    const auto substituted = SubstitutedAsset::with_one_response(asset, own.curves, point_of[path]);
    const Eigen::Index count = last - first;
    const Replayed rows = follow(substituted.view(), row_range(paths, first, count), depth_m);
    replayed.force_N.middleRows(first, count) = rows.force_N;
    std::ranges::copy(rows.is_sliding, replayed.is_sliding.begin() + first);
  }
  return replayed;
}

}  // namespace

std::vector<StatedError> error_causes(const runtime::AssetView& asset, const Reference& reference,
                                      const Replayed& engine, double depth_m, int jobs) {
  const FittedCurves own = own_curves(asset, reference.own, 1, jobs);
  const FittedCurves finer = own_curves(asset, reference.own, 2, jobs);
  const std::vector<Eigen::Index> point_of = own_points(reference);
  const Samples& paths = reference.paths;
  const Replayed with_own = replay_with_own(asset, paths, point_of, own, depth_m);
  const Replayed with_finer = replay_with_own(asset, paths, point_of, finer, depth_m);
  const Replayed nudged = follow(SubstitutedAsset::nudged(asset, 1).view(), paths, depth_m);

  // The part of the rest across the normal is the friction law's where the contact slides.
  const Points rest = with_finer.force_N - paths.force;
  Points sliding_part = Points::Zero(rest.rows(), 3);
  Replayed in_place(paths);  // a difference stands in place of an answer's error
  for (Eigen::Index row = 0; row < rest.rows(); ++row) {
    const Eigen::Index p = point_of[paths.point[row]];
    in_place.is_answered[row] =
        p >= 0 && own.status[p] != FitStatus::failed && finer.status[p] != FitStatus::failed;
    if (!with_finer.is_sliding[row]) continue;
    const Vec3 normal = paths.point_normal.row(paths.point[row]), all = rest.row(row);
    sliding_part.row(row) = all - all.dot(normal) * normal;
  }
  const ErrorFloors floors{relative_floor_N(paths)};
  const auto cause = [&](const char* name, const Points& difference) {
    in_place.force_N = paths.force + difference;
    return stated_error(name, compare(paths, in_place), floors);
  };
  return {
      cause("interpolation", engine.force_N - with_own.force_N),
      cause("curve_fit", with_own.force_N - with_finer.force_N),
      cause("curve_family", rest - sliding_part),
      cause("friction_law", sliding_part),
      cause("float_precision", nudged.force_N - engine.force_N),
  };
}

std::vector<StatedError> baseline_errors(const runtime::AssetView& asset,
                                         const Reference& reference, double depth_m, double first_m,
                                         const FittedCurves* curves, const Model* model) {
  std::vector<StatedError> baselines;
  const ErrorFloors floors{relative_floor_N(reference.paths)};
  const auto add = [&](const char* name, const runtime::AssetView& simpler) {
    const Replayed replayed = follow(simpler, reference.paths, depth_m);
    baselines.push_back(stated_error(name, compare(reference.paths, replayed), floors));
  };
  const bool belongs = curves && model && model->surface.vertices.rows() == asset.vertices;
  if (belongs)
    add("nearest_point",
        SubstitutedAsset::with_nearest_point(asset, curves->curves, *model).view());
  add("one_response", SubstitutedAsset::with_mean_response(asset).view());
  add("linear", SubstitutedAsset::linear(asset, first_m).view());
  if (asset.damage.softens()) {
    runtime::AssetView undamaged = asset;
    undamaged.damage = {};
    add("undamaged", undamaged);
  }
  return baselines;
}

}  // namespace palpate::validation
