#include "libfit/validation/causes.hpp"

#include <algorithm>
#include <cmath>

#include "libfit/core/stated_error.hpp"
#include "libfit/fit/fit_curves.hpp"

namespace palpate::validation {
namespace {

// One vertex's controls as an asset holds them, part by part.
std::vector<float> row_of(const CurveSet& curves, Eigen::Index row) {
  std::vector<float> values;
  for (const Controls& control : curves.control)
    for (const double value : control.row(row)) values.push_back(static_cast<float>(value));
  return values;
}

// Faded vertices at a border are all zero and vertices without test points answer with the mean:
// they stay so.
bool answers(const runtime::AssetView& asset, int vertex) {
  const float* first = asset.node(vertex);
  return asset.covered[vertex] == runtime::kMeasured &&
         std::any_of(first, first + asset.controls_per_vertex,
                     [](float value) { return value != 0; });
}

// Curves of the held-out points from their own experiments, on the same knots.
FittedCurves own_curves(const runtime::AssetView& asset, const Samples& own, int split, int jobs) {
  FitOptions options = options_for(own);
  options.family = static_cast<CurveFamily>(asset.curves.family);
  options.degree = asset.curves.view[0].degree;
  options.sways = asset.sways;
  for (std::size_t kind = 0; kind < curves_of(options.family); ++kind) {
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

CurveBasis basis_of(const runtime::AssetView& asset, int part) {
  const runtime::SplineView& view = asset.curves.view[part];
  if (view.pieces == 0) return {2, {}};
  return {view.degree, {view.knots, view.knots + view.pieces + 1}};
}

std::vector<double> press_changes(const runtime::AssetView& asset, const Surface& surface,
                                  double depth_m) {
  const auto log_force = [&](int vertex) {
    return std::log(runtime::curve_value(asset.curves.view[0],
                                         asset.node(vertex) + asset.control_offset[0], depth_m));
  };
  std::vector<double> changes(surface.triangles.rows(), 0.0);
  for (std::size_t t = 0; t < changes.size(); ++t) {
    const auto corner = surface.triangles.row(t);
    if (!std::ranges::all_of(corner, [&](int v) { return answers(asset, v); })) continue;
    const auto [a, b, c] = corners_of(surface, t);
    Eigen::Matrix<double, 2, 3> edges;
    edges << (b - a).transpose(), (c - a).transpose();
    const Eigen::Vector2d rise(log_force(corner[1]) - log_force(corner[0]),
                               log_force(corner[2]) - log_force(corner[0]));
    const double change = (edges.transpose() * (edges * edges.transpose()).inverse() * rise).norm();
    if (std::isfinite(change)) changes[t] = change;
  }
  return changes;
}

SubstitutedAsset::SubstitutedAsset(const runtime::AssetView& asset)
    : view_(asset),
      control_(asset.control, asset.control + std::size_t(asset.records) *
                                                  std::size_t(asset.controls_per_vertex)) {
  view_.control = control_.data();
}

SubstitutedAsset SubstitutedAsset::with_one_response(const runtime::AssetView& asset,
                                                     const CurveSet& curves, Eigen::Index row) {
  SubstitutedAsset out(asset);
  const std::vector<float> values = row_of(curves, row);
  out.bases_ = std::unique_ptr<fit::Bases>(new fit::Bases(fit::bases_of(curves)));
  out.view_.curves = out.bases_->views;
  out.view_.controls_per_vertex = static_cast<int>(values.size());
  int offset = 0;
  for (std::size_t part = 0; part < curves.control.size(); ++part) {
    out.view_.control_offset[part] = offset;
    offset += static_cast<int>(curves.control[part].cols());
  }
  out.control_ = values;
  out.view_.control = out.control_.data();
  out.record_.assign(asset.vertices, 0);
  out.covered_.assign(asset.vertices, 1);
  out.view_.record = out.record_.data();
  out.view_.records = 1;
  out.view_.covered = out.covered_.data();
  return out;
}

SubstitutedAsset SubstitutedAsset::with_mean_response(const runtime::AssetView& asset) {
  SubstitutedAsset out(asset);
  const auto stride = static_cast<std::size_t>(asset.controls_per_vertex);
  std::vector<double> sum(stride, 0.0);
  double count = 0;
  for (int v = 0; v < asset.vertices; ++v) {
    if (!answers(asset, v)) continue;
    ++count;
    for (std::size_t j = 0; j < stride; ++j) sum[j] += asset.node(v)[j];
  }
  for (int v = 0; v < asset.vertices; ++v)
    for (std::size_t j = 0; j < stride && answers(asset, v); ++j)
      out.control_[std::size_t(asset.record[v]) * stride + j] = static_cast<float>(sum[j] / count);
  return out;
}

std::vector<StatedError> error_causes(const runtime::AssetView& asset, const Reference& reference,
                                      const Replayed& engine, double depth_m, int jobs) {
  const FittedCurves own = own_curves(asset, reference.own, 1, jobs);
  const FittedCurves finer = own_curves(asset, reference.own, 2, jobs);
  const std::vector<Eigen::Index> point_of = own_points(reference);
  const Samples& paths = reference.paths;
  const Replayed with_own = replay_with_own(asset, paths, point_of, own, depth_m);
  const Replayed with_finer = replay_with_own(asset, paths, point_of, finer, depth_m);

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
  };
}

std::vector<StatedError> baseline_errors(const runtime::AssetView& asset,
                                         const Reference& reference, double depth_m) {
  std::vector<StatedError> baselines;
  const ErrorFloors floors{relative_floor_N(reference.paths)};
  const auto add = [&](const char* name, const runtime::AssetView& simpler) {
    const Replayed replayed = follow(simpler, reference.paths, depth_m);
    baselines.push_back(stated_error(name, compare(reference.paths, replayed), floors));
  };
  add("one_response", SubstitutedAsset::with_mean_response(asset).view());
  if (asset.damage.softens()) {
    runtime::AssetView undamaged = asset;
    undamaged.damage = {};
    add("undamaged", undamaged);
  }
  return baselines;
}

}  // namespace palpate::validation
