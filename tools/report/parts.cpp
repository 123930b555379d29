#include "tools/report/report_page.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "libfem/mesh/topology.hpp"
#include "libfit/assets/asset_file.hpp"
#include "libfit/core/curves.hpp"
#include "libfit/fit/spline/monotone_least_squares.hpp"
#include "libfit/io/csv/csv.hpp"
#include "libfit/io/files/files.hpp"
#include "libfit/validation/replay.hpp"
#include "tools/scene/canonical.hpp"

namespace palpate::tools {
namespace {

namespace fs = std::filesystem;

constexpr int kCurveSteps = 60;  // of a curve that is drawn
constexpr int kDepths = 14;      // at which the surface is coloured

Json surface_json(const Surface& surface) {
  return {{"vertices_m", packed_as<float>(surface.vertices)},
          {"triangles", packed_as<std::int32_t>(surface.triangles)}};
}

Json probe_json(const ProbeSpec& probe) {
  Json json{{"shape", probe.shape}, {"friction", probe.friction}, {"values", Json::object()}};
  for (const auto& [key, values] : probe.values) json["values"][key] = values;
  return json;
}

// Colours of the surface: a row per depth, of covered vertices alone.
Json maps_json(const Model& model) {
  const NodeForces forces(model.curves);
  const double range_m = model.curves.basis[0].knots_m.back();
  std::vector<std::int32_t> vertices;
  for (std::int32_t v = 0; v < std::ssize(model.is_covered); ++v)
    if (model.is_covered[v]) vertices.push_back(v);
  std::vector<float> force, stiffness, friction;
  std::vector<double> depths;
  for (int k = 1; k <= kDepths; ++k) {
    const double depth = range_m * k / kDepths;
    depths.push_back(depth);
    for (const std::int32_t v : vertices) {
      const double normal = forces.normal_N(v, depth);
      force.push_back(static_cast<float>(normal));
      stiffness.push_back(static_cast<float>(forces.normal_slope_N_m(v, depth)));
      friction.push_back(normal > 0 ? static_cast<float>(forces.limit_N(v, depth) / normal)
                                    : std::numeric_limits<float>::quiet_NaN());
    }
  }
  return {{"depths_m", depths},
          {"vertices", packed(vertices)},
          {"force_N", packed(force)},
          {"stiffness_N_m", packed(stiffness)},
          {"friction", packed(friction)}};
}

// Values at equal abscissae from 0 to the last knot, of each point in turn.
template <class Value>
std::vector<float> sampled(Eigen::Index points, double last_knot_m, const Value& value) {
  std::vector<float> values;
  for (Eigen::Index p = 0; p < points; ++p)
    for (int step = 0; step <= kCurveSteps; ++step)
      values.push_back(static_cast<float>(value(p, last_knot_m * step / kCurveSteps)));
  return values;
}

// The curves of one kind, with standard errors where they are known.
Json curve_json(const FittedCurves& fitted, std::size_t kind) {
  const SplineTables tables = tabulate(fitted.curves.basis[kind]);
  const runtime::SplineView spline = fit::view(tables);
  const Controls &control = fitted.curves.control[kind], &covariance = fitted.covariance[kind];
  const double last_m = tables.knots.back();
  const auto value = [&](Eigen::Index p, double at) {
    return runtime::curve_value(spline, control.row(p).data(), at);
  };
  const auto deviation = [&](Eigen::Index p, double at) {
    return fit::curve_deviation(spline, covariance.row(p), at);
  };
  return {{"name", kCurveNames[kind]},
          {"knots_m", tables.knots},
          {"value_N", packed(sampled(control.rows(), last_m, value))},
          {"deviation_N", packed(sampled(covariance.rows(), last_m, deviation))}};
}

Json numbers_json(const Vec3& v) { return {v[0], v[1], v[2]}; }

// A region as it is drawn: a ball, a box or a surface; nothing of others.
Json region_json(const Region& region) {
  if (const auto* ball = std::get_if<Ball>(&region))
    return {{"center_m", numbers_json(ball->center_m)}, {"radius_m", ball->radius_m}};
  if (const auto* box = std::get_if<Box>(&region))
    return {{"low_m", numbers_json(box->low_m)}, {"high_m", numbers_json(box->high_m)}};
  if (const auto* solid = std::get_if<Solid>(&region))
    return surface_json(solid->boundary->surface);
  return Json::object();
}

// The scene's text, and the regions of it that are drawn.
void add_scene(Json& set_up, const Body& body) {
  set_up["scene"] = body.scene;
  set_up["inclusions"] = Json::array();
  if (body.scene.empty()) return;
  const Scene scene = scene_of(body, "body.h5");
  if (const auto& window = scene.experiments.region) set_up["window"] = region_json(*window);
  for (const InclusionSection& inclusion : scene.inclusions)
    set_up["inclusions"].push_back(region_json(inclusion.region));
}

}  // namespace

void add_body(Json& json, const Body& body) {
  json["surface"] = surface_json(body.surface);
  std::vector<std::int32_t> held;
  for (std::int32_t n = 0; n < std::ssize(body.is_held); ++n)
    if (body.is_held[n]) held.push_back(n);
  const Triangles boundary = fem::boundary_triangles(body.volume.tets);
  const std::vector<char> is_lumen = faces_of_lumens(body.volume.nodes, boundary);
  std::vector<Eigen::Index> lumen;
  for (Eigen::Index f = 0; f < std::ssize(is_lumen); ++f)
    if (is_lumen[f]) lumen.push_back(f);
  json["set_up"] = {{"held", packed(held)},
                    {"nodes_m", packed_as<float>(body.volume.nodes)},
                    {"boundary", packed_as<std::int32_t>(boundary)},
                    {"lumen", packed_as<std::int32_t>(Triangles(boundary(lumen, Eigen::all)))},
                    {"points_m", packed_as<float>(body.test_points.position)}};
  add_scene(json["set_up"], body);
  if (body.probe) json["probe"] = probe_json(*body.probe);
  for (const std::string& sentence : body.mended) json["warnings"].push_back(sentence);
}

void add_model(Json& json, const Model& model) {
  Json surface = surface_json(model.surface);
  if (!json.contains("surface")) {
    json["surface"] = std::move(surface);
  } else if (json["surface"]["vertices_m"] != surface["vertices_m"]) {
    json["surface"] = std::move(surface);
    json["warnings"].push_back(
        "body.h5 has another surface than model.h5, which is shown: run `palpate run` again.");
  }
  json["surface"]["inward_normal"] = packed_as<float>(model.inward_normal);
  json["maps"] = maps_json(model);
}

void add_curves(Json& json, const FittedCurves& fitted) {
  Json points{{"position_m", packed_as<float>(fitted.position)},
              {"inward_normal", packed_as<float>(fitted.normal)},
              {"name", fitted.name},
              {"message", fitted.message},
              {"rms_residual_N", packed_as<float>(fitted.rms_residual_N)},
              {"max_residual_N", packed_as<float>(fitted.max_residual_N)},
              {"depth_range_m", packed_as<float>(fitted.depth_range_m)},
              {"status", Json::array()},
              {"curves", Json::array()}};
  for (const FitStatus status : fitted.status)
    points["status"].push_back(kFitStatusNames[static_cast<std::size_t>(status)]);
  const std::size_t kinds = curves_of(fitted.curves.family);
  for (std::size_t kind = 0; kind < kinds; ++kind)
    points["curves"].push_back(curve_json(fitted, kind));
  json["family"] = name_of(fitted.curves.family);
  json["points"] = std::move(points);
  if (!json.contains("probe") && fitted.probe) json["probe"] = probe_json(*fitted.probe);
}

// Rows as they were measured or simulated, and what the curves of their own point answer.
void add_samples(Json& json, const Samples& samples, const FittedCurves* fitted) {
  Replayed replayed(samples);
  std::vector<std::int32_t> point_of(samples.point_name.size(), -1);
  for (std::int32_t p = 0; fitted && p < std::ssize(point_of); ++p) {
    const auto found = std::ranges::find(fitted->name, samples.point_name[p]);
    if (found == fitted->name.end()) continue;
    point_of[p] = static_cast<std::int32_t>(found - fitted->name.begin());
    if (fitted->status[point_of[p]] != FitStatus::failed)
      validation::replay_point(samples, p, fitted->curves, point_of[p], replayed);
  }
  Points answer = replayed.force_N;
  std::vector<std::int32_t> point;
  for (Eigen::Index row = 0; row < samples.rows(); ++row) {
    point.push_back(point_of[samples.point[row]]);
    if (!replayed.is_answered[row]) answer.row(row).setConstant(std::nan(""));
  }
  json["rows"] = {{"point", packed(point)},
                  {"experiment", packed(samples.experiment)},
                  {"kind", packed_as<std::uint8_t>(samples.kind)},
                  {"deflection_m", packed_as<float>(samples.deflection)},
                  {"force_N", packed_as<float>(samples.force)},
                  {"force_error_N", packed_as<float>(samples.force_error)},
                  {"fitted_N", packed_as<float>(answer)},
                  {"status", packed_as<std::uint8_t>(samples.status)},
                  {"status_names", kRowStatusNames}};
}

void add_held_out(Json& json, const fs::path& path) {
  static constexpr std::pair<const char*, std::array<const char*, 3>> kVectors[] = {
      {"position_m", {"x_m", "y_m", "z_m"}},
      {"deflection_m", {"dx_m", "dy_m", "dz_m"}},
      {"force_N", {"fx_N", "fy_N", "fz_N"}},
      {"engine_N", {"ex_N", "ey_N", "ez_N"}}};
  std::vector<CsvColumnRule> rules{{"point", true, true}, {"path", true, true}, {"t_s", false}};
  for (const auto& [key, names] : kVectors)
    for (const char* name : names) rules.push_back({name});
  const CsvTable table = read_csv(path, rules);
  Json& held_out =
      json["held_out"] = {{"point", table.text("point")}, {"path", table.text("path")}};
  for (const auto& [key, names] : kVectors) {
    std::vector<float> values;
    for (std::size_t row = 0; row < table.rows(); ++row)
      for (const char* name : names) values.push_back(static_cast<float>(table.number(name)[row]));
    held_out[key] = packed(values);
  }
  if (table.has("t_s")) held_out["time_s"] = packed_as<float>(table.number("t_s"));
}

void add_asset(Json& json, const fs::path& path) {
  const AssetFile file = read_asset_file(path);
  if (!json.contains("surface")) json["surface"] = surface_json(surface_of(file.asset()));
  json["asset"] = {{"bytes", base64(read_whole_file(path))},
                   {"range_m", file.asset().max_fitted_m}};
  const Json meta = Json::parse(file.meta_json(), nullptr, false);
  if (meta.contains("program")) json["asset"]["program"] = meta["program"];
  if (meta.contains("tools")) json["tools"] = meta["tools"];
  const Json::json_pointer error("/statement/force_error");
  if (meta.contains(error) && json.contains(error) && meta.at(error) != json.at(error))
    json["warnings"].push_back(
        "statement.json is of another asset than asset.palp: run `palpate run` again.");
}

}  // namespace palpate::tools
