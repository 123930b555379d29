// The error statement of an asset that was made of recordings.

#include <algorithm>
#include <nlohmann/json.hpp>

#include "libfit/assets/asset_file.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/core/stated_error.hpp"
#include "libfit/io/files/files.hpp"
#include "libfit/refine/refine.hpp"
#include "libfit/validation/replay.hpp"
#include "tools/stages/export.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/import.hpp"
#include "tools/stages/statement_sections.hpp"
#include "tools/stages/validate.hpp"

namespace palpate::tools {
namespace {

using namespace validation;

// Rows that the engine follows, of recordings with the asset's own probe.
Samples followed(const Samples& samples) {
  return of_kinds(samples, {ExperimentKind::press, ExperimentKind::drag, ExperimentKind::path});
}

double deepest_m(const Samples& samples) {
  double deepest_m = 0;
  for (Eigen::Index row = 0; row < samples.rows(); ++row)
    deepest_m = std::max(
        deepest_m, samples.deflection.row(row).dot(samples.point_normal.row(samples.point[row])));
  return deepest_m;
}

void check_probe(const std::filesystem::path& path, const AssetFile& file, const Samples& samples) {
  const auto meta = nlohmann::json::parse(file.meta_json(), nullptr, false);
  if (!samples.probe || !meta.is_object() || !meta.contains("probe")) return;
  if (meta["probe"] != nlohmann::json::parse(probe_meta(*samples.probe)))
    throw Error(path.string(), "was measured with another probe than the samples",
                "Validate it with the samples that it was fitted to.");
}

}  // namespace

std::filesystem::path held_out_path(std::filesystem::path samples_path) {
  return samples_path.replace_extension(".held_out.h5");
}

RecordedSamples read_recorded(const std::filesystem::path& samples_path) {
  const std::filesystem::path held_out = held_out_path(samples_path);
  return {read_samples(samples_path),
          std::filesystem::exists(held_out) ? read_samples(held_out) : Samples()};
}

Statement validate_recordings(const std::filesystem::path& path, const RecordedSamples& samples,
                              const ValidateRequest& request, const Body* body) {
  const AssetFile file = read_asset_file(path);
  const runtime::AssetView& asset = file.asset();
  check_probe(path, file, samples.fitted);
  // Depths count from the surface, as import has it of a surface that the manifest names.
  Samples held_out = followed(samples.held_out);
  const PlacedPoints places = placed_points(asset, held_out);
  const Samples as_placed = rows_at(held_out, places.is_covered, true);
  held_out.point_position = places.position;
  RecordedReference recorded{followed(samples.fitted), rows_at(held_out, places.is_covered, false),
                             as_placed};
  RefineReport refined;
  if (request.curves != nullptr && body != nullptr) {
    refine(*request.curves, *body, {.is_measured = true}, &refined);
    recorded.left_out = &refined.interpolation;
  }
  Reference reference;
  reference.paths = rows_at(held_out, places.is_covered, true);
  const double depth_m = std::max(deepest_m(recorded.fitted), deepest_m(held_out));
  const Replayed engine = follow(asset, reference.paths, depth_m);
  const Comparison compared = compare(reference.paths, engine);
  const ErrorFloors floors{std::max(relative_floor_N(recorded.fitted), relative_floor_N(held_out)),
                           0};
  Statement statement = summarize(compared, floors);
  statement.is_recorded = true;
  statement.probes = reference.paths.points();
  statement.beyond = recorded.beyond.points();
  statement.reference_failures = reference.paths.rows() - compared.rows.size();
  const Samples& timed = compared.rows.empty() ? recorded.fitted : reference.paths;
  if (timed.rows() > 0) statement.all.tick_ns = time_ticks_ns(asset, timed, depth_m);
  const Scene none;
  const StatedAsset of{asset,  asset,   none,    reference, engine, asset.probe_radius_m,
                       floors, request, depth_m, &recorded};
  if (!request.rows_csv.empty()) write_compared_rows(request.rows_csv, of);
  statement.sections = statement_sections(of);
  statement.asset_bytes = asset.file.bytes;
  return statement;
}

}  // namespace palpate::tools
