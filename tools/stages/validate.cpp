#include "tools/stages/validate.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "libfem/materials/materials.hpp"
#include "libfem/probes/probes.hpp"
#include "libfit/assets/asset_file.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/core/stated_error.hpp"
#include "libfit/io/files/files.hpp"
#include "libfit/refine/refine.hpp"
#include "libfit/shape/shape.hpp"
#include "libfit/validation/causes.hpp"
#include "libfit/validation/replay.hpp"
#include "tools/console.hpp"
#include "tools/stages/body/prepare.hpp"
#include "tools/stages/import.hpp"
#include "tools/stages/model.hpp"
#include "tools/stages/samples/experiment_table.hpp"
#include "tools/stages/samples/placement.hpp"
#include "tools/stages/samples/sample_cache.hpp"

namespace palpate::tools {
namespace {

using namespace validation;

// Refuses an asset of another body: its vertices are the scene's, rounded to float.
void check_same_surface(const std::filesystem::path& path, const runtime::AssetView& asset,
                        const Surface& surface) {
  const Points vertices = palpate::surface_of(asset).vertices, &scenes = surface.vertices;
  const bool is_as_many = vertices.rows() == scenes.rows();
  if (is_as_many && begin_alike(vertices, scenes)) return;
  throw Error(
      path.string(),
      fmt::format("was made on another surface than the scene's: {} vertices and {}{}",
                  vertices.rows(), scenes.rows(),
                  is_as_many ? fmt::format(", {:.3g} mm apart",
                                           1e3 * (vertices - scenes).rowwise().norm().maxCoeff())
                             : ""),
      "Validate it with the scene that it was made from.");
}

// "sphere, friction 0.3, radius_m 0.008".
std::string probe_words(const nlohmann::json& probe) {
  std::string words = probe.value("shape", "probe of no known shape");
  for (const auto& [key, value] : probe.items())
    if (key != "shape") words += fmt::format(", {} {}", key, value.dump());
  return words;
}

bool is_alike(const nlohmann::json& a, const nlohmann::json& b) {
  if (a.is_number() && b.is_number())
    // Lengths were in other units.
    return std::abs(a.get<double>() - b.get<double>()) <= 1e-9 * std::abs(a.get<double>());
  if (a.type() != b.type() || a.size() != b.size() || !a.is_structured()) return a == b;
  for (const auto& [key, value] : a.items()) {
    const auto other = a.is_array() ? b.begin() + std::stol(key) : b.find(key);
    if (other == b.end() || !is_alike(value, *other)) return false;
  }
  return true;
}

// An asset played against another tool than its own differs by what the tools do, and one that was
// changed by what was.
void warn_of_other_probe(const std::filesystem::path& path, std::string_view meta_json,
                         const ProbeSpec& wanted) {
  const auto meta = nlohmann::json::parse(meta_json, nullptr, false);
  const auto scene = nlohmann::json::parse(probe_meta(wanted));
  if (!meta.is_object() || !meta.contains("probe")) {
    warn("{}: does not say which probe it is of; the reference is of the scene's ({})",
         path.string(), probe_words(scene));
  } else if (!is_alike(meta["probe"], scene)) {
    warn(
        "{}: was measured with another probe ({}) than the scene's ({}): the statement says how "
        "right it is for the scene's",
        path.string(), probe_words(meta["probe"]), probe_words(scene));
  }
  if (meta.is_object() && meta.contains("changed"))
    warn("{}: export changed it ({}): the scene needs the same change", path.string(),
         meta["changed"].dump());
}

// Draws the held-out experiments of a scene and simulates them, but for those that `reference.h5`
// of the request's folder holds already. An interruption (exception Interrupted) keeps what is
// done.
Reference simulate_reference(const runtime::AssetView& asset, const Scene& scene, const Body& body,
                             const ValidateRequest& request) {
  Reference out;
  const HeldOut held_out = draw_held_out_paths({scene, body, body.test_points, Purpose::hold_out});
  const Simulators simulators(scene, body, Purpose::hold_out);
  const std::filesystem::path output =
      request.reference.empty() ? request.reference : request.reference / "reference.h5";
  const SimulateRequest simulate =
      request_for(scene, body, Purpose::hold_out, request.jobs, output, request.resume);
  out.all = SampleCache(simulate).at(
      std::cref(simulators),
      draw_experiments({scene, body, held_out.points, Purpose::hold_out,
                        press_changes(asset, body.surface, scene.experiments.each.depth_m)}),
      experiments_of(scene), "validate");
  out.paths = paths_of(out.all, false);
  out.own = of_kinds(out.all, {ExperimentKind::press, ExperimentKind::drag});
  if (output.empty()) return out;
  write_with_surface(output, out.all, attributes_of(simulate));
  remove_partial(output);
  return out;
}

// Rows that the engine follows, of recordings with the asset's own probe.
Samples followed(const Samples& samples) {
  return of_kinds(samples, {ExperimentKind::press, ExperimentKind::drag, ExperimentKind::path,
                            ExperimentKind::scan});
}

void check_probe(const std::filesystem::path& path, const AssetFile& file, const Samples& samples) {
  const auto meta = nlohmann::json::parse(file.meta_json(), nullptr, false);
  if (!samples.probe || !meta.is_object() || !meta.contains("probe")) return;
  if (meta["probe"] != nlohmann::json::parse(probe_meta(*samples.probe)))
    throw Error(path.string(), "was measured with another probe than the samples",
                "Validate it with the samples that it was fitted to.");
}

// The statement of compared rows, but for what simulated and recorded references have alone.
Statement stated(const StatedAsset& of, const Comparison& compared, const Samples& timed) {
  Statement statement = summarize(compared, of.floors);
  statement.probes = of.reference.paths.points();
  statement.reference_failures = of.reference.paths.rows() - compared.rows.size();
  if (timed.rows() > 0) statement.all.tick_ns = time_ticks_ns(of.met, timed, of.depth_m);
  if (!of.request.rows_csv.empty()) write_compared_rows(of.request.rows_csv, of);
  statement.sections = statement_sections(of);
  statement.asset_bytes = of.asset.file.bytes;
  return statement;
}

}  // namespace

std::optional<TruthInterval> interval_of(const Scene& scene, double held_share,
                                         double replay_p95_rel) {
  const fem::Material material = fem::make_material(*scene.material, "[material]");
  return truth_interval({scene.validate.young_deviation,
                         material.law->small_strain(material.constants).poisson(),
                         scene.validate.poisson_deviation, scene.probe.spec.friction,
                         scene.validate.friction_deviation, held_share, replay_p95_rel});
}

Samples paths_of(const Samples& reference, bool are_where_it_changes) {
  const Samples paths = of_kinds(reference, {ExperimentKind::path});
  std::vector<char> changes;
  for (const std::string& name : paths.point_name) changes.push_back(name[0] == kChangeName);
  return rows_at(paths, changes, are_where_it_changes);
}

Statement validate_asset(const std::filesystem::path& path, const Scene& scene, const Body& body,
                         const ValidateRequest& request) {
  const AssetFile file = read_asset_file(path);
  const runtime::AssetView& asset = file.asset();
  check_same_surface(path, asset, body.surface);
  warn_of_other_probe(path, file.meta_json(), scene.probe.spec);
  const double depth_m = scene.experiments.each.depth_m;
  const Reference reference = simulate_reference(asset, scene, body, request);
  IndenterAssets indenter_assets(asset);
  const auto end = own_end(scene);
  const runtime::AssetView* other = end ? indenter_assets.of(*end) : nullptr;
  const runtime::AssetView& met = other != nullptr ? *other : asset;
  const Replayed engine = follow(met, reference.paths, depth_m);
  const Levers levers{fem::round_end_m(*scene.probe.rigid), scene.validate.handle_m};
  const Comparison compared = compare(reference.paths, engine, levers);
  const StatedAsset of{asset,   met,    scene, reference, engine, levers, floors_of(compared),
                       request, depth_m};
  Statement statement = stated(of, compared, reference.paths);
  if (scene.validate.causes && body.test_points.position.rows() > 0) {
    const Eigen::Index middle = middle_point(scene, body);
    Progress progress;
    progress.is_stopped = [] { return is_interrupted(); };
    statement.held_share =
        fem::Simulator(make_setup(scene, body))
            .held_share(body.test_points.position.row(middle), body.test_points.normal.row(middle),
                        experiments_of(scene), progress);
    if (progress.stopped()) throw Interrupted("validate: nothing was written");
  }
  statement.interval = interval_of(scene, statement.held_share, statement.all.magnitude.p95);
  if (asset.shape.points > 0 && reference.paths.surface.cols() == 3 * asset.vertices)
    statement.shape =
        shape_error(met, reference.paths, contact_states(met, reference.paths, depth_m));
  return statement;
}

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
  for (const Samples* of : {&samples.fitted, &samples.held_out}) check_probe(path, file, *of);
  // Depths count from the surface, as import has it of a surface that the manifest names.
  Samples held_out = followed(samples.held_out);
  PlacedPoints places = placed_points(asset, held_out);
  for (Eigen::Index row = 0; row < held_out.rows(); ++row)  // `by_reach` has a scan's rows
    if (held_out.kind[row] == ExperimentKind::scan) places.is_covered[held_out.point[row]] = 1;
  const Samples as_placed = rows_at(held_out, places.is_covered, true);
  held_out.point_position = places.position;
  RecordedReference recorded{followed(samples.fitted), rows_at(held_out, places.is_covered, false),
                             as_placed};
  RefineReport refined;
  if (request.curves != nullptr && body != nullptr && !are_scanned(samples.fitted)) {
    refine(*request.curves, *body, {.is_measured = true}, &refined);
    recorded.left_out = &refined.interpolation;
  }
  Reference reference;
  reference.paths = rows_at(held_out, places.is_covered, true);
  double depth_m = std::max(deepest_m(recorded.fitted), deepest_m(held_out));
  if (!(depth_m > 0)) depth_m = asset.max_fitted_m;  // scans
  const Replayed engine = follow(asset, reference.paths, depth_m);
  const Comparison compared = compare(reference.paths, engine);
  const ErrorFloors floors{std::max(relative_floor_N(recorded.fitted), relative_floor_N(held_out)),
                           0};
  const Scene none;
  const StatedAsset of{asset,  asset,   none,    reference, engine, Levers{asset.probe_radius_m},
                       floors, request, depth_m, &recorded};
  Statement statement =
      stated(of, compared, compared.rows.empty() ? recorded.fitted : reference.paths);
  statement.is_recorded = true;
  statement.beyond = recorded.beyond.points();
  return statement;
}

}  // namespace palpate::tools
