#include "tools/stages/validate.hpp"

#include <fmt/core.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "libfem/probes/probes.hpp"
#include "libfem/solve/experiments/cycled_path.hpp"
#include "libfem/solve/experiments/simulate.hpp"
#include "libfem/solve/experiments/timed_path.hpp"
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
#include "tools/stages/samples/cycles.hpp"
#include "tools/stages/samples/kept_paths.hpp"
#include "tools/stages/samples/sample_cache.hpp"
#include "tools/stages/samples/simulate.hpp"

namespace palpate::tools {
namespace {

using namespace validation;

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

// Of the deepest press, by which a body that softens is pressed before a held-out path.
constexpr double kLeastPreload = 0.5;

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
  const double end_radius_m = fem::round_end_m(fem::make_probe(scene.probe.spec, "[probe]"));
  statement.torque = torque_errors(reference, engine, end_radius_m);
  if (request.settings.causes)
    statement.causes = error_causes(asset, reference, engine, depth_m, request.jobs);
  statement.baselines =
      baseline_errors(asset, reference, depth_m, depth_m / scene.experiments.each.press_steps,
                      request.curves, request.model);
  statement.tick_ns = time_ticks_ns(asset, reference.held_out, depth_m);
  if (asset.shape.points > 0 && reference.paths.surface.cols() == 3 * asset.vertices)
    statement.shape =
        shape_error(asset, reference.paths, contact_states(asset, reference.paths, depth_m));
  statement.asset_bytes = asset.file_bytes;
  return statement;
}

namespace {

using namespace validation;

std::string path_fingerprint(const ReferenceRequest& request, const HeldOut& held_out) {
  ContentHash hash;
  hash.add(request.fingerprint);
  const auto add = [&](const Points& rows) {
    hash.add({reinterpret_cast<const char*>(rows.data()),
              static_cast<std::size_t>(rows.size()) * sizeof(double)});
  };
  add(held_out.points.position);
  if (request.settings.force_tolerance > 0)
    hash.add(fmt::format("{}", request.settings.force_tolerance));
  for (const ToolPath& path : held_out.paths) {
    add(path.deflections);
    for (const double time_s : path.time_s) hash.add(fmt::format("{}", time_s));
    if (!path.lean.isZero()) hash.add(fmt::format("{} {}", path.lean.x(), path.lean.y()));
  }
  return hash.hex();
}

Samples simulate_held_out_paths(const fem::Simulator& simulator, const HeldOut& held_out,
                                const ReferenceRequest& request) {
  return simulate_kept_paths(
      simulator, held_out.points, held_out.paths,
      {.what = "validate",
       .jobs = request.jobs,
       .output = request.folder.empty() ? request.folder : request.folder / "reference.h5",
       .fingerprint = path_fingerprint(request, held_out),
       .resume = request.resume});
}

}  // namespace

Reference simulate_reference(const Scene& scene, const Body& body,
                             const ReferenceRequest& request) {
  Reference reference;
  const fem::ToolReach reach = make_reach(scene, body.surface);
  const auto can_touch = [&](const Vec3& position, const Vec3& inward) {
    return reach.is_free(position, inward);
  };
  const auto can_lean = [&](const Vec3& position, const Vec3& inward, const Lean& lean) {
    return reach.is_free(position, inward, lean);
  };
  reference.held_out =
      draw_held_out(body,
                    {scene.experiments.each.depth_m, scene.experiments.each.drag_distance_m,
                     can_touch, request.settings.tilt_rad, can_lean},
                    request.settings.points, static_cast<std::uint64_t>(request.settings.seed));
  if (relaxes(scene)) {
    const std::vector<double>& speeds = request.settings.speeds_m_s;
    std::size_t turn = 0;
    for (ToolPath& path : reference.held_out.paths)
      path = fem::in_time(path, speeds[turn++ % speeds.size()], request.settings.hold_s);
  }
  if (softens(scene)) {  // pressed there once before: what was borne counts
    constexpr double kTurn = 0.6180339887498949;
    for (std::size_t i = 0; i < reference.held_out.paths.size(); ++i) {
      ToolPath& path = reference.held_out.paths[i];
      const double turn = kTurn * static_cast<double>(i + 1);
      path =
          fem::after_press(path, reference.held_out.points.normal.row(path.point),
                           scene.experiments.each.depth_m *
                               (kLeastPreload + (1 - kLeastPreload) * (turn - std::floor(turn))));
    }
  }
  const double tolerance = request.settings.force_tolerance;
  reference.paths = simulate_held_out_paths(
      make_simulator(scene, body, tolerance > 0 ? tolerance : scene.experiments.force_tolerance),
      reference.held_out, request);
  if (!request.settings.causes) return reference;
  const fem::Simulator simulator(make_setup(scene, body));
  const std::filesystem::path output =
      request.folder.empty() ? request.folder : request.folder / "reference_own.h5";
  SampleCache known({request.jobs, output, request.fingerprint, request.resume});
  reference.own = known.at(simulator, reference.held_out.points, experiments_of(scene),
                           "validate, at the points themselves");
  if (output.empty()) return reference;
  write_samples(output, reference.own, {{kPointFingerprintAttribute, request.fingerprint}});
  remove_partial(output);
  return reference;
}

}  // namespace palpate::tools
