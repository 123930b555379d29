#include "libfit/validation/causes.hpp"

#include "libfit/fit/fit_curves.hpp"
#include "libfit/validation/compared_paths.hpp"
#include "libfit/validation/substitute.hpp"

namespace palpate::validation {
namespace {

// Curves of the held-out points from their own experiments, on given knots.
FittedCurves own_curves(const runtime::AssetView& asset, const Samples& own, int split, int jobs) {
  FitOptions options;
  options.family = static_cast<CurveFamily>(asset.curves.family);
  options.degree = asset.curves.view[0].degree;
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

// Each path with the curves of its own point all over the surface.
std::vector<Followed> follow_with_own(const runtime::AssetView& asset, const HeldOut& held_out,
                                      const FittedCurves& own, double depth_m) {
  std::vector<Followed> followed;
  for (std::size_t path = 0; path < held_out.paths.size(); ++path) {
    const auto point = static_cast<Eigen::Index>(path);
    HeldOut one;
    one.points.position = held_out.points.position.row(point);
    one.points.normal = held_out.points.normal.row(point);
    one.paths.push_back({0, held_out.paths[path].deflections});
    const auto substituted = SubstitutedAsset::with_one_response(asset, own.curves, point);
    followed.push_back(follow_paths(substituted.view(), one, depth_m).front());
  }
  return followed;
}

// Reference rows with a given difference in place of an answer's error.
template <class Difference>
NamedError cause(const std::string& name, const Reference& reference,
                 const std::vector<char>& is_known, const Difference& difference) {
  std::vector<ComparedRow> rows;
  for (const PathRow& at : good_rows(reference.paths)) {
    if (!is_known[at.path]) continue;
    ComparedRow row{at.force_N, at.force_N, 0};
    row.engine_N += difference(at);
    rows.push_back(row);
  }
  return named_error(name, rows);
}

}  // namespace

std::vector<NamedError> error_causes(const runtime::AssetView& asset, const Reference& reference,
                                     const std::vector<Followed>& engine, double depth_m,
                                     int jobs) {
  const HeldOut& held_out = reference.held_out;
  const FittedCurves own = own_curves(asset, reference.own, 1, jobs);
  const FittedCurves finer = own_curves(asset, reference.own, 2, jobs);
  std::vector<char> is_known;
  for (std::size_t point = 0; point < own.status.size(); ++point)
    is_known.push_back(own.status[point] != FitStatus::failed &&
                       finer.status[point] != FitStatus::failed);
  const auto with_own = follow_with_own(asset, held_out, own, depth_m);
  const auto with_finer = follow_with_own(asset, held_out, finer, depth_m);
  const auto nudged = follow_paths(SubstitutedAsset::nudged(asset, 1).view(), held_out, depth_m);

  const auto left = [&](const PathRow& at) -> Vec3 {
    return force_at(with_finer, at) - at.force_N;
  };
  // Of what is left where the contact slides, the part across the normal is the friction law's.
  const auto sliding_part = [&](const PathRow& at) -> Vec3 {
    if (!with_finer[at.path].is_sliding[static_cast<std::size_t>(at.step)]) return Vec3::Zero();
    const Vec3 normal = held_out.points.normal.row(static_cast<Eigen::Index>(at.path));
    return left(at) - left(at).dot(normal) * normal;
  };
  return {
      cause(
          "interpolation", reference, is_known,
          [&](const PathRow& at) -> Vec3 { return force_at(engine, at) - force_at(with_own, at); }),
      cause("curve_fit", reference, is_known,
            [&](const PathRow& at) -> Vec3 {
              return force_at(with_own, at) - force_at(with_finer, at);
            }),
      cause("curve_family", reference, is_known,
            [&](const PathRow& at) -> Vec3 { return left(at) - sliding_part(at); }),
      cause("friction_law", reference, is_known, sliding_part),
      cause("float_precision", reference, is_known,
            [&](const PathRow& at) -> Vec3 { return force_at(nudged, at) - force_at(engine, at); }),
  };
}

std::vector<NamedError> baseline_errors(const runtime::AssetView& asset, const Reference& reference,
                                        double depth_m, double first_m, const FittedCurves* curves,
                                        const Model* model) {
  std::vector<NamedError> baselines;
  const auto add = [&](const char* name, const SubstitutedAsset& substituted) {
    const auto followed = follow_paths(substituted.view(), reference.held_out, depth_m);
    baselines.push_back(named_error(name, compared_rows(reference.paths, followed)));
  };
  const bool belongs = curves && model && model->surface.vertices.rows() == asset.vertices;
  if (belongs)
    add("nearest_point", SubstitutedAsset::with_nearest_point(asset, curves->curves, *model));
  add("one_response", SubstitutedAsset::with_mean_response(asset));
  add("linear", SubstitutedAsset::linear(asset, first_m));
  return baselines;
}

std::vector<NamedError> errors_by_path(const Reference& reference,
                                       const std::vector<Followed>& engine) {
  std::vector<NamedError> errors;
  for (std::size_t kind = 0; kind < kPathKindNames.size(); ++kind) {
    std::vector<ComparedRow> rows;
    for (const PathRow& at : good_rows(reference.paths))
      if (static_cast<std::size_t>(reference.held_out.kind[at.path]) == kind)
        rows.push_back({at.force_N, force_at(engine, at), at.error_N});
    if (!rows.empty()) errors.push_back(named_error(std::string(kPathKindNames[kind]), rows));
  }
  return errors;
}

}  // namespace palpate::validation
