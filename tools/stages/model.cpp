#include "tools/stages/model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "libfem/mesh/read/raw_mesh.hpp"
#include "libfem/mesh/topology.hpp"
#include "libfem/probes/probes.hpp"
#include "libfit/assets/asset_bytes.hpp"
#include "libfit/assets/asset_file.hpp"
#include "libfit/assets/exporters.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/experiments.hpp"
#include "libfit/core/stated_error.hpp"
#include "libfit/core/units.hpp"
#include "libfit/fit/contact_effects.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/files/files.hpp"
#include "libfit/refine/interpolation.hpp"
#include "libfit/refine/refine.hpp"
#include "libfit/shape/shape.hpp"
#include "libfit/validation/replay.hpp"
#include "tools/console.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/samples/experiment_table.hpp"
#include "tools/stages/samples/sample_cache.hpp"

namespace palpate::tools {
namespace {

// Exponent of a probe's contact radius over depth, to the nearest power (M30).
ShapeOptions options_for(const fem::Probe& probe, double depth_m) {
  ShapeOptions options;
  options.depth_m = depth_m;
  options.radius_m = probe.contact_radius_m(depth_m);
  const double quarter_m = probe.contact_radius_m(depth_m / 4);
  options.radius_power =
      std::clamp(static_cast<int>(std::lround(std::log2(options.radius_m / quarter_m))), 0, 2);
  return options;
}

// Identifies how the body's surface moves from samples that tell it, and puts it into the model
// that was made of their curves; says what was chosen. Leaves the model as it is where the samples
// tell nothing of its surface.
void add_shape(Model& model, const Samples& samples) {
  if (!samples.probe || samples.surface.cols() != 3 * model.surface.vertices.rows()) return;
  const double depth_m = deepest_m(samples);
  if (!(depth_m > 0)) return;
  const double from_s = wall_seconds();
  const AssetBytes bytes = make_asset_bytes(model, {});
  runtime::Status status;
  const auto asset = runtime::Asset::open(bytes.data(), bytes.size(), &status);
  model.shape = identify_shape(asset, samples, model.blend_point, model.blend_weight,
                               options_for(fem::make_probe(*samples.probe, "[probe]"), depth_m));
  if (model.shape.point.rows() == 0) return;
  say("  shape: {} fields of the whole body beside the dent ({:.1f} s)", model.shape.modes,
      wall_seconds() - from_s);
}

void say_kind(const runtime::AssetView& asset, const runtime::CouplingView& coupling,
              const Scene& scene, const Samples& all, ExperimentKind kind, const char* what) {
  const Samples rows = of_kinds(all, {kind});
  if (rows.rows() == 0) return;
  const auto error = [&](const runtime::AssetView& view) {
    const Replayed answered = follow(view, rows, scene.experiments.each.depth_m,
                                     played_as(scene, Purpose::identify, rows));
    return validation::summarize(validation::compare(rows, answered)).all.force;
  };
  const auto felt = error(coupled_by(asset, coupling)), alone = error(coupled_by(asset, {}));
  say("  {}: forces of {} rows are off by {} (median), {} (p95) if contacts feel each other, {} "
      "and {} if not",
      what, rows.rows(), stated_percent(felt.median_rel), stated_percent(felt.p95_rel),
      stated_percent(alone.median_rel), stated_percent(alone.p95_rel));
}

// Identifies how contacts feel each other (M62) from the pairs and the paths of [tool] among the
// samples, into the model, and says how well; nothing where there are none.
void add_coupling(Model& model, const Scene& scene, const Samples& samples) {
  const Samples rows = of_kinds(samples, {ExperimentKind::pair, ExperimentKind::tool});
  if (rows.rows() == 0) return;
  if (model.curves.family != CurveFamily::rings) {
    say("  coupling: the curves are {}, and only rings feel another contact",
        name_of(model.curves.family));
    return;
  }
  const AssetBytes bytes = make_asset_bytes(model, {});
  runtime::Status status;
  const auto asset = runtime::Asset::open(bytes.data(), bytes.size(), &status);
  runtime::CouplingView& coupling = model.curves.coupling;
  coupling = identify_coupling(asset,
                               coupling_residual(asset, rows, scene.experiments.each.depth_m,
                                                 played_as(scene, Purpose::identify, rows)),
                               // The coupling's least scale over the ball's radius (M62).
                               0.5 * ball_radius_m(scene.probe.spec));
  say_kind(asset, coupling, scene, rows, ExperimentKind::pair, "two tools");
  say_kind(asset, coupling, scene, rows, ExperimentKind::tool, "tool");
  if (!coupling.is_any()) say("  coupling: that is no gain, there is none");
}

}  // namespace

double deepest_m(const Samples& samples) {
  double deepest_m = 0;
  for (Eigen::Index row = 0; row < samples.rows(); ++row)
    if (samples.kind[row] != ExperimentKind::scan)  // counts from where a pass begins
      deepest_m = std::max(
          deepest_m, samples.deflection.row(row).dot(samples.point_normal.row(samples.point[row])));
  return deepest_m;
}

Samples read_known(const std::filesystem::path& samples) {
  return std::filesystem::exists(surface_path(samples)) ? read_with_surface(samples)
                                                        : read_samples(samples);
}

bool are_scanned(const Samples& samples) {
  return std::ranges::count(samples.kind, ExperimentKind::scan) > 0;
}

Model refine_body(const FittedCurves& curves, const Body& body, const Samples& samples,
                  const Scene* scene) {
  RefineReport report;
  Model model = refine(curves, body,
                       {.tool = fem::round_end(curves.probe),
                        .is_measured = scene == nullptr && !are_scanned(samples)},
                       &report);
  if (static_cast<Eigen::Index>(report.left_out.size()) == curves.position.rows())
    throw Error(
        "curves",
        fmt::format("none of the {} test points lies on this body with curves of its own",
                    curves.position.rows()),
        "Name the body.h5 that the samples were taken on; `fit` lists points without curves.");
  say("  {} test points spread over {} triangles{}; largest distance of a vertex {:.2f} mm",
      curves.position.rows() - static_cast<Eigen::Index>(report.left_out.size()),
      report.triangles.rows(),
      report.is_own_triangulation ? " made for them, since they are not the body's own" : "",
      1e3 * report.largest_projection_m);
  if (const InterpolationChoice& chosen = report.interpolation; chosen.points > 0)
    say("  {} test points left out are predicted to {:.1f} % (mean) by area alone, {:.1f} % with "
        "the slopes of side forces, {:.1f} % over the force of the gap under the tool{}: {}",
        chosen.points, 100 * chosen.plain_error, 100 * chosen.slope_error, 100 * chosen.gap_error,
        chosen.kriged_error > 0 ? fmt::format(", {:.1f} % kriged", 100 * chosen.kriged_error) : "",
        chosen.is_kriged         ? "forces are kriged"
        : chosen.follows_gap     ? "forces follow the gap"
        : chosen.slope_share > 0 ? fmt::format("{:.3g} of the slopes count", chosen.slope_share)
                                 : "area alone");
  if (report.interpolation.kriges_normals)
    say("  normals are kriged from the points' own ({:.1f} degrees off at points left out, the "
        "surface's {:.1f})",
        report.interpolation.kriged_normal_rad * 180 / std::numbers::pi,
        report.interpolation.surface_normal_rad * 180 / std::numbers::pi);
  for (const auto point : report.left_out) {
    const auto p = static_cast<std::size_t>(point);
    say("  left out: {}: {}", curves.name[p],
        curves.message[p].empty() ? "too far from the surface" : curves.message[p]);
  }
  if (!report.uncovered.empty())
    say("  {} reachable vertices are answered for by no test point", report.uncovered.size());
  if (samples.surface.rows() > 0)
    add_shape(model, of_kinds(samples, {ExperimentKind::press, ExperimentKind::drag}));
  if (scene != nullptr) add_coupling(model, *scene, samples);
  return model;
}

Attributes model_attributes(const FittedCurves& curves, const std::string& made_from) {
  Attributes out{{kInputsAttribute, made_from}};
  const auto guessed = std::ranges::count(curves.status, FitStatus::underdetermined);
  const auto failed = std::ranges::count(curves.status, FitStatus::failed);
  if (guessed + failed > 0)
    out[kGuessedAttribute] = fmt::format("{} of {}: {} underdetermined, {} failed",
                                         guessed + failed, curves.status.size(), guessed, failed);
  return out;
}

namespace {

nlohmann::ordered_json probe_json(const ProbeSpec& probe) {
  nlohmann::ordered_json json{{"shape", probe.shape}, {"friction", probe.friction}};
  for (const auto& [key, values] : probe.values) {
    const char* unit = probe_dimension(key) == Dimension::angle ? "_rad" : "_m";
    if (values.size() == 1)
      json[key + unit] = values.front();
    else
      json[key + unit] = values;
  }
  if (const auto& o = probe.orientation) json["orientation"] = {o->x(), o->y(), o->z()};
  if (probe.mesh.triangles.rows() > 0) {
    const Vec3 extent = extent_m(probe.mesh.vertices);
    json["mesh_triangles"] = probe.mesh.triangles.rows();
    json["mesh_extent_m"] = {extent.x(), extent.y(), extent.z()};
  }
  return json;
}

nlohmann::ordered_json tool_json(const NamedTool& named) {
  const runtime::ToolShape& tool = named.tool.shape;
  nlohmann::ordered_json json{{"name", named.name}, {"balls", nlohmann::ordered_json::array()}};
  for (int i = 0; i < tool.balls; ++i) {
    json["balls"].push_back(tool.ball[i].centre_m);
    json["radius_m"].push_back(tool.ball[i].radius_m);
  }
  const Indenter& end = named.tool.end.front();
  if (end.points > 0) {
    json["profile"]["r_m"] = std::vector<double>(end.r_m, end.r_m + end.points);
    json["profile"]["slope"] = std::vector<double>(end.slope, end.slope + end.points);
  }
  return json;
}

}  // namespace

nlohmann::ordered_json json_of(const ModelChanges& changes) {
  nlohmann::ordered_json json;
  if (changes.stiffness != 1) json["stiffness"] = changes.stiffness;
  if (changes.friction) json["friction"] = *changes.friction;
  return json;
}

StiffnessFit stiffness_of_press(const Model& model, const PosePath& path) {
  const AssetBytes bytes = make_asset_bytes(model, {});
  runtime::Status status;
  const auto asset = runtime::Asset::open(bytes.data(), bytes.size(), &status);
  runtime::Contact contact;
  Eigen::VectorXd answered_N(path.position.rows());
  for (Eigen::Index i = 0; i < answered_N.size(); ++i) {
    const Vec3 tip = path.position.row(i);
    runtime::Output out;
    const double dt_s = i > 0 ? path.time_s[i] - path.time_s[i - 1] : runtime::kCheckTick_s;
    runtime::touch(asset, contact, tip.data(), out, nullptr, dt_s);
    answered_N[i] = Vec3::Map(out.force_on_tool_N).norm();
  }
  return fit_stiffness(answered_N,
                       Eigen::Map<const Eigen::VectorXd>(path.force_N.data(), answered_N.size()));
}

ExportReport export_model(const Model& model, const std::filesystem::path& output,
                          const ExportRequest& request) {
  nlohmann::ordered_json meta{{"program", "palpate " PALPATE_VERSION}};
  if (!request.fingerprint.empty()) meta[kInputsAttribute] = request.fingerprint;
  if (model.probe) meta["probe"] = probe_json(*model.probe);
  if (!request.guessed_points.empty()) {
    meta[kGuessedAttribute] = request.guessed_points;
    warn("test points without curves of their own: {}; `fit` says what was assumed of each",
         request.guessed_points);
  }
  if (const auto changes = json_of(request.changes); !changes.is_null()) meta["changed"] = changes;
  for (const NamedTool& tool : request.tools) meta["tools"].push_back(tool_json(tool));
  ExportOptions options;
  options.has_mean_elsewhere = true;
  options.meta_json = meta.dump();
  options.engine_dir = request.engine;
  const ExportReport report = export_palp(model, output, options);
  for (const std::string& remark : report.remarks) say("  {}", remark);
  say("  {}: {} bytes, {} vertices, {} triangles", output.string(), report.bytes, report.vertices,
      report.triangles);
  return report;
}

std::string probe_meta(const ProbeSpec& probe) { return probe_json(probe).dump(); }

namespace {

void write_asset(const std::filesystem::path& path, const AssetBytes& bytes) {
  write_file_atomically(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace

void put_statement(const std::filesystem::path& path, const std::string& statement) {
  const AssetFile file = read_asset_file(path);
  auto meta = nlohmann::ordered_json::parse(file.meta_json());
  meta["statement"] = nlohmann::ordered_json::parse(statement);
  write_asset(path, with_meta(file.asset(), meta.dump()));
}

nlohmann::ordered_json put_visual(const std::filesystem::path& asset,
                                  const std::filesystem::path& mesh,
                                  const std::filesystem::path& output,
                                  const std::string& unit_of_mesh) {
  const AssetFile file = read_asset_file(asset);
  Points place_m = rows_of(mesh_read::read_raw(mesh, false, nullptr).points);
  if (place_m.rows() == 0)
    throw Error(mesh.string(), "has no vertices", "Name the mesh that is drawn.");
  const double body_m = extent_m(surface_of(file.asset()).vertices).norm();
  const auto misfit = [&](const char* unit) {
    const double unit_m = *unit_factor(unit, Dimension::length);
    return std::abs(std::log(unit_m * extent_m(place_m).norm() / body_m));
  };
  const std::string unit =
      unit_of_mesh.empty() ? std::ranges::min({"m", "cm", "mm"}, {}, misfit) : unit_of_mesh;
  place_m *= mesh_unit_m(unit, "--unit");
  const std::vector<runtime::VisualVertex> visual = hang(file.asset(), place_m);
  std::vector<double> off_m;
  for (const runtime::VisualVertex& hung : visual)
    off_m.push_back(Eigen::Map<const Eigen::Vector3f>(hung.offset_m).norm());
  const auto farthest = std::ranges::max_element(off_m);
  // A mesh in another pose or of another body lies so far off; one of the same body some mm.
  if (*farthest > 0.1 * body_m)
    throw Error(mesh.string(),
                fmt::format("vertex {}, taken in {}, is {:.3g} mm from the surface of the body, "
                            "which is {:.3g} mm across",
                            farthest - off_m.begin() + 1, unit, 1e3 * *farthest, 1e3 * body_m),
                "Name its unit with --unit, and place it where the body's own mesh lies.");
  write_asset(output, with_visual(file.asset(), visual));
  const double median_m = stated_quantile(off_m, 0.5);
  if (median_m > 0.02 * body_m)  // a mesh of the same body, coarser or finer, lies within a percent
    warn(
        "half of {} is more than {:.2g} mm off the surface: does it lie where the body's mesh "
        "lies?",
        mesh.string(), 1e3 * median_m);
  say("  {} vertices of {}, taken in {}, hang on the surface, {:.2g} mm off it (median), {:.2g} mm "
      "(max)",
      visual.size(), mesh.string(), unit, 1e3 * median_m, 1e3 * *farthest);
  return {
      {"vertices", visual.size()}, {"unit", unit}, {"median_m", median_m}, {"max_m", *farthest}};
}

}  // namespace palpate::tools
