#include "tools/stages/validate.hpp"

#include <fmt/core.h>

#include <cmath>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>

#include "libfem/probes/probes.hpp"
#include "libfit/assets/asset_file.hpp"
#include "libfit/core/error.hpp"
#include "libfit/io/content_hash.hpp"
#include "libfit/io/csv/csv.hpp"
#include "libfit/io/files/files.hpp"
#include "libfit/shape/contact_states.hpp"
#include "libfit/validation/causes.hpp"
#include "libfit/validation/torque.hpp"
#include "tools/console.hpp"
#include "tools/stages/body/reach.hpp"
#include "tools/stages/export.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/samples/compound.hpp"
#include "tools/stages/samples/experiment_table.hpp"
#include "tools/stages/samples/sample_cache.hpp"
#include "tools/stages/samples/simulate.hpp"

namespace palpate::tools {
namespace {

using namespace validation;

// Reference and answer of every row of [tool], as validation.csv has those of the probe.
void write_tool_rows(const std::filesystem::path& path, const Samples& samples,
                     const FollowedRows& by) {
  static constexpr std::string_view kHeader[] = {
      "point", "step", "status", "lean_1", "lean_2", "dx_m",  "dy_m",  "dz_m",  "fx_N",  "fy_N",
      "fz_N",  "ex_N", "ey_N",   "ez_N",   "tx_Nm",  "ty_Nm", "tz_Nm", "ux_Nm", "uy_Nm", "uz_Nm"};
  CsvWriter csv(path, kHeader);
  for (Eigen::Index row = 0; row < samples.rows(); ++row) {
    const auto r = static_cast<std::size_t>(row);
    csv.text(samples.point_name[static_cast<std::size_t>(samples.point[r])])
        .integer(samples.step[r])
        .text(kRowStatusNames[static_cast<std::size_t>(samples.status[r])]);
    for (int k = 0; k < 2; ++k) csv.number(samples.lean.rows() > 0 ? samples.lean(row, k) : 0);
    for (const Points* three :
         {&samples.deflection, &samples.force, &by.force_N, &samples.torque, &by.torque_Nm})
      for (int k = 0; k < 3; ++k) csv.number((*three)(row, k));
    csv.end_row();
  }
  csv.commit();
}

void write_rows(const std::filesystem::path& path, const Reference& reference,
                const Replayed& engine) {
  static constexpr std::string_view kHeader[] = {
      "point", "path",  "step",  "x_m",   "y_m",   "z_m",  "dx_m", "dy_m",
      "dz_m",  "fx_N",  "fy_N",  "fz_N",  "ex_N",  "ey_N", "ez_N", "error_N",
      "tx_Nm", "ty_Nm", "tz_Nm", "ux_Nm", "uy_Nm", "uz_Nm"};
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
    csv.number((answer - force).norm());
    for (int k = 0; k < 3; ++k) csv.number(rows.torque(row, k));
    for (int k = 0; k < 3; ++k) csv.number(engine.torque_Nm(row, k));
    csv.end_row();
  }
  csv.commit();
}

NamedError error_of(std::string name, const Samples& rows, const FollowedRows& by, double floor_N) {
  return named_error(std::move(name), compare(rows, by.force_N), floor_N);
}

// Held-out paths of two tools, and each tool by itself.
void state_pairs(const runtime::AssetView& asset, const Scene& scene, const Samples& all,
                 Statement& statement) {
  const Samples rows = of_kinds(all, {ExperimentKind::pair});
  if (rows.rows() == 0) return;
  const double depth_m = scene.experiments.each.depth_m;
  const auto by = [&](const char* name, const runtime::AssetView& view) {
    statement.two_tools.push_back(
        error_of(name, rows, follow(view, rows, depth_m), statement.floor_N));
  };
  by("felt", asset);
  by("each_by_itself", coupled_by(asset, {}));
  statement.two_tools_tick_ns = time_ticks_ns(asset, rows, depth_m);
}

// Held-out paths of [tool]: as balls that feel each other, as balls by themselves, and as its
// foremost ball alone.
void state_tool(const runtime::AssetView& asset, const Scene& scene, const Samples& all,
                const std::filesystem::path& rows_csv, Statement& statement) {
  const Samples rows = of_kinds(all, {ExperimentKind::tool});
  if (rows.rows() == 0) return;
  const double depth_m = scene.experiments.each.depth_m;
  const PlayedAs whole = [&](Eigen::Index row) { return tool_played_as(scene, rows, row); };
  const PlayedAs foremost = [&](Eigen::Index row) { return foremost_played_as(scene, rows, row); };
  const auto by = [&](const char* name, const runtime::AssetView& view, const PlayedAs& played_as) {
    const FollowedRows answered = follow(view, rows, depth_m, played_as);
    statement.tool.push_back(error_of(name, rows, answered, statement.floor_N));
    std::vector<ComparedTorque> torques;
    for (Eigen::Index row = 0; row < rows.rows(); ++row)
      if (rows.status[static_cast<std::size_t>(row)] == RowStatus::good)
        torques.push_back({rows.torque.row(row), answered.torque_Nm.row(row)});
    statement.tool_torque.push_back(named_torque(name, torques, torque_floor_Nm(torques)));
    return answered;
  };
  const FollowedRows felt = by("felt", asset, whole);
  if (!rows_csv.empty()) write_tool_rows(rows_csv.parent_path() / "tool.csv", rows, felt);
  by("each_by_itself", coupled_by(asset, {}), whole);
  by("foremost_ball", coupled_by(asset, {}), foremost);
  statement.tool_tick_ns = time_ticks_ns(asset, rows, depth_m, whole);
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

// "sphere, friction 0.3, radius_m 0.008".
std::string probe_words(const nlohmann::json& probe) {
  std::string words = probe.value("shape", "probe of no known shape");
  for (const auto& [key, value] : probe.items())
    if (key != "shape") words += fmt::format(", {} {}", key, value.dump());
  return words;
}

bool is_alike(const nlohmann::json& a, const nlohmann::json& b) {
  constexpr double kRounding = 1e-9;  // of lengths in other units
  if (a.is_number() && b.is_number())
    return std::abs(a.get<double>() - b.get<double>()) <= kRounding * std::abs(a.get<double>());
  if (a.type() != b.type() || a.size() != b.size() || !a.is_structured()) return a == b;
  for (const auto& [key, value] : a.items()) {
    const auto other = a.is_array() ? b.begin() + std::stol(key) : b.find(key);
    if (other == b.end() || !is_alike(value, *other)) return false;
  }
  return true;
}

// An asset played against another tool than its own differs by what the tools do.
void warn_of_other_probe(const std::filesystem::path& path, std::string_view meta_json,
                         const ProbeSpec& wanted) {
  const auto meta = nlohmann::json::parse(meta_json, nullptr, false);
  const auto scene = nlohmann::json::parse(probe_meta(wanted));
  if (!meta.is_object() || !meta.contains("probe")) {
    warn("{}: does not say which probe it is of; the reference is of the scene's ({})",
         path.string(), probe_words(scene));
  } else if (!is_alike(meta["probe"], scene)) {
    warn(
        "{}: is of another probe ({}) than the scene's ({}), and is compared with the scene's as "
        "if it were its own: the errors hold what the two probes differ by. For the error of the "
        "asset itself give [probe] of the scene the asset's numbers",
        path.string(), probe_words(meta["probe"]), probe_words(scene));
  }
}

}  // namespace

Statement validate_asset(const std::filesystem::path& path, const Scene& scene, const Body& body,
                         const ValidateRequest& request) {
  const AssetFile file = read_asset_file(path);
  const runtime::AssetView& asset = file.asset();
  check_same_surface(path, asset, body.surface);
  warn_of_other_probe(path, file.meta_json(), scene.probe.spec);
  const double depth_m = scene.experiments.each.depth_m;
  const SimulatedReference reference =
      simulate_reference(scene, body,
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
  const double end_radius_m = fem::round_end_m(fem::make_probe(scene.probe.spec, "[probe]"));
  statement.torque = torque_errors(reference, engine, end_radius_m);
  if (request.settings.causes)
    statement.causes = error_causes(asset, reference, engine, depth_m, request.jobs);
  statement.baselines =
      baseline_errors(asset, reference, depth_m, depth_m / scene.experiments.each.press_steps,
                      request.curves, request.model);
  statement.tick_ns = time_ticks_ns(asset, reference.paths, depth_m);
  state_pairs(asset, scene, reference.all, statement);
  state_tool(asset, scene, reference.all, request.rows_csv, statement);
  if (asset.shape.points > 0 && reference.paths.surface.cols() == 3 * asset.vertices)
    statement.shape =
        shape_error(asset, reference.paths, contact_states(asset, reference.paths, depth_m));
  statement.asset_bytes = asset.file_bytes;
  return statement;
}

SimulatedReference simulate_reference(const Scene& whole, const Body& body,
                                      const ReferenceRequest& request) {
  Scene scene = whole;
  scene.validate = request.settings;
  SimulatedReference out;
  out.held_out = draw_held_out_paths({scene, body, body.test_points, Purpose::hold_out});
  const Simulators simulators(scene, body, Purpose::hold_out);
  const std::filesystem::path output =
      request.folder.empty() ? request.folder : request.folder / "reference.h5";
  const SimulateRequest simulate{.jobs = request.jobs,
                                 .output = output,
                                 .fingerprint = request.fingerprint,
                                 .tool = tool_fingerprint(scene),
                                 .resume = request.resume,
                                 .has_surface = keeps_surface(scene, body)};
  out.all = SampleCache(simulate).at(
      std::cref(simulators),
      draw_experiments({scene, body, out.held_out.points, Purpose::hold_out}),
      experiments_of(scene), "validate");
  out.paths = of_kinds(out.all, {ExperimentKind::path});
  out.own = of_kinds(out.all, {ExperimentKind::press, ExperimentKind::drag});
  if (output.empty()) return out;
  write_with_surface(output, out.all, attributes_of(simulate));
  remove_partial(output);
  return out;
}

}  // namespace palpate::tools
