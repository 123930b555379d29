#include "libfit/validation/causes.hpp"

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

// Of each path the number of its place in `own`; -1 where nothing else was done there.
std::vector<Eigen::Index> own_points(const Reference& reference) {
  std::vector<Eigen::Index> out;
  const Points &places = reference.held_out.points.position, &own = reference.own.point_position;
  for (std::size_t path = 0; path < reference.held_out.paths.size(); ++path) {
    Eigen::Index p = own.rows() - 1;
    while (p >= 0 && own.row(p) != places.row(static_cast<Eigen::Index>(path))) --p;
    out.push_back(p);
  }
  return out;
}

// Each path with the curves of its own point all over the surface, where it has some.
Replayed replay_with_own(const runtime::AssetView& asset, const Reference& reference,
                         const std::vector<Eigen::Index>& point_of, const FittedCurves& own,
                         double depth_m) {
  Replayed replayed(reference.paths);
  for (std::size_t path = 0; path < point_of.size(); ++path) {
    if (point_of[path] < 0) continue;
    const auto substituted = SubstitutedAsset::with_one_response(asset, own.curves, point_of[path]);
    replay_path(substituted.view(), reference, path, depth_m, replayed);
  }
  return replayed;
}

// Path of a reference row.
std::size_t path_of(const Reference& reference, Eigen::Index row) {
  return reference.paths.point[row];
}

}  // namespace

std::vector<StatedError> error_causes(const runtime::AssetView& asset, const Reference& reference,
                                      const Replayed& engine, double depth_m, int jobs) {
  const FittedCurves own = own_curves(asset, reference.own, 1, jobs);
  const FittedCurves finer = own_curves(asset, reference.own, 2, jobs);
  const std::vector<Eigen::Index> point_of = own_points(reference);
  std::vector<char> is_known;
  for (const Eigen::Index p : point_of)
    is_known.push_back(p >= 0 && own.status[static_cast<std::size_t>(p)] != FitStatus::failed &&
                       finer.status[static_cast<std::size_t>(p)] != FitStatus::failed);
  const Replayed with_own = replay_with_own(asset, reference, point_of, own, depth_m);
  const Replayed with_finer = replay_with_own(asset, reference, point_of, finer, depth_m);
  const Replayed nudged =
      replay(SubstitutedAsset::nudged(asset, 1).view(), reference.paths, depth_m);

  // Of what is left where the contact slides, the part across the normal is the friction law's.
  const Points left = with_finer.force_N - reference.paths.force;
  Points sliding_part = Points::Zero(left.rows(), 3);
  for (Eigen::Index row = 0; row < left.rows(); ++row) {
    if (!with_finer.is_sliding[row]) continue;
    const Vec3 normal = reference.held_out.points.normal.row(path_of(reference, row));
    const Vec3 all = left.row(row);
    sliding_part.row(row) = all - all.dot(normal) * normal;
  }
  const ErrorFloors floors{relative_floor_N(reference.paths)};
  // A difference stands in place of an answer's error.
  const auto cause = [&](const char* name, const Points& difference) {
    return stated_error(
        name,
        compare(reference.paths, reference.paths.force + difference,
                [&](Eigen::Index row) { return is_known[path_of(reference, row)] != 0; }),
        floors);
  };
  return {
      cause("interpolation", engine.force_N - with_own.force_N),
      cause("curve_fit", with_own.force_N - with_finer.force_N),
      cause("curve_family", left - sliding_part),
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
    const Replayed replayed = replay(simpler, reference.paths, depth_m);
    baselines.push_back(stated_error(name, compare(reference.paths, replayed), floors));
  };
  const bool belongs = curves && model && model->surface.vertices.rows() == asset.vertices;
  if (belongs)
    add("nearest_point",
        SubstitutedAsset::with_nearest_point(asset, curves->curves, *model).view());
  add("one_response", SubstitutedAsset::with_mean_response(asset).view());
  add("linear", SubstitutedAsset::linear(asset, first_m).view());
  if (asset.damage.softens()) {
    runtime::AssetView whole = asset;
    whole.damage = {};
    add("undamaged", whole);
  }
  return baselines;
}

std::vector<StatedError> errors_by(const Samples& reference, const Replayed& engine,
                                   double radius_m, const ErrorFloors& floors,
                                   std::span<const std::string_view> names,
                                   const std::function<std::size_t(Eigen::Index row)>& group) {
  std::vector<StatedError> errors;
  for (std::size_t g = 0; g < names.size(); ++g) {
    const auto rows = compare_torques(reference, engine, radius_m,
                                      [&](Eigen::Index row) { return group(row) == g; });
    if (!rows.empty()) errors.push_back(stated_error(std::string(names[g]), rows, floors));
  }
  return errors;
}

}  // namespace palpate::validation
