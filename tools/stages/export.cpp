#include "tools/stages/export.hpp"

#include <nlohmann/json.hpp>

#include "libfit/assets/asset_bytes.hpp"
#include "libfit/assets/asset_file.hpp"
#include "libfit/assets/exporters.hpp"
#include "libfit/core/error.hpp"
#include "libfit/io/atomic_file.hpp"
#include "tools/console.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/refine.hpp"

namespace palpate::tools {

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

ExportReport export_model(const Model& model, const std::filesystem::path& output,
                          const std::string& format, const ExportRequest& request) {
  nlohmann::ordered_json meta{{"program", "palpate " PALPATE_VERSION}};
  if (!request.fingerprint.empty()) meta[kInputsAttribute] = request.fingerprint;
  if (model.probe) meta["probe"] = probe_json(*model.probe);
  if (!request.guessed_points.empty()) {
    meta[kGuessedAttribute] = request.guessed_points;
    warn("test points without curves of their own: {}; `fit` says what was assumed of each",
         request.guessed_points);
  }
  for (const NamedTool& tool : request.tools) meta["tools"].push_back(tool_json(tool));
  ExportOptions options;
  options.has_mean_elsewhere = true;
  options.meta_json = meta.dump();
  options.map_depth_m = request.map_depth_m;
  options.engine_dir = request.engine;
  const ExportReport report = find_exporter(format).write(model, output, options);
  for (const std::string& remark : report.remarks) say("  {}", remark);
  say("  {}: {} bytes, {} vertices, {} triangles", output.string(), report.bytes, report.vertices,
      report.triangles);
  return report;
}

std::string probe_meta(const ProbeSpec& probe) { return probe_json(probe).dump(); }

void put_statement(const std::filesystem::path& path, const std::string& statement) {
  const AssetFile file = read_asset_file(path);
  auto meta = nlohmann::ordered_json::parse(file.meta_json());
  meta["statement"] = nlohmann::ordered_json::parse(statement);
  const AssetBytes bytes = with_meta(file.asset(), meta.dump());
  write_file_atomically(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace palpate::tools
