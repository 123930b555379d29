#include "tools/stages/validate.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "libfit/assets/asset_file.hpp"
#include "libfit/core/error.hpp"
#include "libfit/io/csv/csv.hpp"
#include "libfit/validation/causes.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/reference.hpp"

namespace palpate::tools {
namespace {

using namespace validation;

void write_rows(const std::filesystem::path& path, const Reference& reference,
                const Replayed& engine) {
  static constexpr std::string_view kHeader[] = {"point", "path", "step", "x_m",    "y_m",  "z_m",
                                                 "dx_m",  "dy_m", "dz_m", "fx_N",   "fy_N", "fz_N",
                                                 "ex_N",  "ey_N", "ez_N", "error_N"};
  CsvWriter csv(path, kHeader);
  const Samples& rows = reference.paths;
  for (Eigen::Index row = 0; row < rows.rows(); ++row) {
    const auto r = static_cast<std::size_t>(row);
    if (rows.status[r] != RowStatus::good) continue;
    const Vec3 force = rows.force.row(row), answer = engine.force_N.row(row);
    const auto point = static_cast<std::size_t>(rows.point[r]);
    csv.text(rows.point_name[point])
        .text(kPathKindNames[static_cast<std::size_t>(reference.held_out.kind[point])])
        .integer(rows.step[r]);
    for (int k = 0; k < 3; ++k) csv.number(rows.point_position(rows.point[r], k));
    for (int k = 0; k < 3; ++k) csv.number(rows.deflection(row, k));
    for (int k = 0; k < 3; ++k) csv.number(force[k]);
    for (int k = 0; k < 3; ++k) csv.number(answer[k]);
    csv.number((answer - force).norm()).end_row();
  }
  csv.commit();
}

// Refuses an asset of another body: its vertices are the scene's, rounded to float.
void check_same_surface(const std::filesystem::path& path, const runtime::AssetView& asset,
                        const Surface& surface) {
  constexpr double kRounding = 1e-6;  // of the body's extent
  double farthest_m =
      asset.vertices == surface.vertices.rows() ? 0 : std::numeric_limits<double>::infinity();
  for (int v = 0; v < asset.vertices && std::isfinite(farthest_m); ++v) {
    const Vec3 place = Eigen::Map<const Eigen::Vector3f>(asset.vertex + 3 * v).cast<double>() +
                       Eigen::Map<const Vec3>(asset.origin_m);
    farthest_m = std::max(farthest_m, (place - Vec3(surface.vertices.row(v))).norm());
  }
  if (farthest_m <= kRounding * extent_m(surface.vertices).norm()) return;
  throw Error(
      path.string(),
      fmt::format(
          "was made on another surface than the scene's: {} vertices and {}{}", asset.vertices,
          surface.vertices.rows(),
          std::isfinite(farthest_m) ? fmt::format(", {:.3g} mm apart", 1e3 * farthest_m) : ""),
      "Validate it with the scene that it was made from.");
}

}  // namespace

Statement validate_asset(const std::filesystem::path& path, const Scene& scene, const Body& body,
                         const ValidateRequest& request) {
  const AssetFile file = read_asset_file(path);
  const runtime::AssetView& asset = file.asset();
  check_same_surface(path, asset, body.surface);
  const double depth_m = scene.experiments.each.depth_m;
  const Reference reference = simulate_reference(scene, body,
                                                 {.settings = request.settings,
                                                  .jobs = request.jobs,
                                                  .folder = request.reference,
                                                  .fingerprint = point_fingerprint(scene, body),
                                                  .resume = request.resume});
  const Replayed engine = replay_paths(asset, reference, depth_m);
  if (!request.rows_csv.empty()) write_rows(request.rows_csv, reference, engine);
  const std::vector<ComparedRow> rows = compare(reference.paths, engine);
  Statement statement = summarize(rows);
  statement.probes = reference.held_out.paths.size();
  statement.reference_failures = static_cast<std::size_t>(reference.paths.rows()) - rows.size();
  statement.by_path = errors_by_path(reference, engine);
  if (request.settings.causes)
    statement.causes = error_causes(asset, reference, engine, depth_m, request.jobs);
  statement.baselines =
      baseline_errors(asset, reference, depth_m, depth_m / scene.experiments.each.press_steps,
                      request.curves, request.model);
  statement.tick_ns = time_ticks_ns(asset, reference.held_out, depth_m);
  statement.asset_bytes = asset.file_bytes;
  return statement;
}

}  // namespace palpate::tools
