#include "tools/stages/fingerprint.hpp"

#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "libfit/assets/asset_file.hpp"
#include "libfit/core/error.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/files/files.hpp"
#include "tools/build_identity.hpp"
#include "tools/scene/settings.hpp"

namespace palpate::tools {
namespace {

// Begins with the stage's name and the program.
ContentHash stage_hash(const char* stage) {
  ContentHash hash;
  hash.add(stage).add(build_identity());
  return hash;
}

std::optional<std::string> fingerprint_in(const std::string& json) {
  const auto parsed = nlohmann::json::parse(json, nullptr, false);
  if (!parsed.is_object() || !parsed.contains(kInputsAttribute) ||
      !parsed[kInputsAttribute].is_string())
    return std::nullopt;
  return parsed[kInputsAttribute].get<std::string>();
}

template <class Matrix>
std::string_view bytes_of(const Matrix& matrix) {
  return {reinterpret_cast<const char*>(matrix.data()),
          static_cast<std::size_t>(matrix.size()) * sizeof(typename Matrix::Scalar)};
}

}  // namespace

std::string import_fingerprint() { return stage_hash("import").hex(); }

std::string body_fingerprint(const Scene& scene) {
  ContentHash hash = stage_hash("body");
  hash.add(canonical(scene, Stage::prepare));
  ProbeSpec shape = scene.probe.spec;  // what it reaches depends on the tool and how deep it goes
  shape.friction = 0;
  hash.add(canonical(shape)).add(fmt::format("{}", scene.experiments.each.depth_m));
  // How far it bends, and what its beds leave of the region.
  if (scene.gravity || !scene.beds.empty()) hash.add(canonical(scene, Stage::simulate));
  hash.add_file(scene.body.surface ? *scene.body.surface : *scene.body.tetmesh);
  if (scene.experiments.points_file) hash.add_file(*scene.experiments.points_file);
  return hash.hex();
}

std::string point_fingerprint(const Scene& scene, const Body& body) {
  ContentHash hash = stage_hash("samples");
  hash.add(canonical(scene, Stage::simulate));
  hash.add(canonical(scene.body));  // what is held between the nodes of the base mesh
  hash.add(bytes_of(body.surface.vertices)).add(bytes_of(body.surface.triangles));
  hash.add(bytes_of(body.volume.nodes)).add(bytes_of(body.volume.tets));
  hash.add(bytes_of(body.volume.region));
  hash.add({body.is_held.data(), body.is_held.size()});
  return hash.hex();
}

std::string samples_fingerprint(const Scene& scene, const Body& body) {
  ContentHash hash;
  hash.add(point_fingerprint(scene, body));
  hash.add(bytes_of(body.test_points.position)).add(bytes_of(body.test_points.normal));
  for (const std::string& name : body.test_points.name) hash.add(name);
  if (!scene.experiments.placement) return hash.hex();
  hash.add(canonical(scene, Stage::place)).add(canonical(scene, Stage::fit));
  hash.add(bytes_of(body.test_points.triangles));
  hash.add({body.is_reachable.data(), body.is_reachable.size()});
  return hash.hex();
}

std::string cycles_fingerprint(const Scene& scene, const std::filesystem::path& samples) {
  ContentHash hash = stage_hash("cycles");
  return hash.add(std::to_string(scene.experiments.cycles)).add_file(samples).hex();
}

std::string pairs_fingerprint(const Scene& scene, const Body& body) {
  ContentHash hash = stage_hash("pairs");
  return hash.add(std::to_string(scene.experiments.pairs))
      .add(point_fingerprint(scene, body))
      .hex();
}

std::string tool_fingerprint(const Scene& scene, const Body& body) {
  const ToolSection& tool = *scene.tool;
  const Experiments& each = scene.experiments.each;
  return stage_hash("tool")
      .add(point_fingerprint(scene, body))
      .add(canonical(tool.probe.spec))
      .add(fmt::format("{} {} {} {} {}", tool.row, tool.tilt_rad, tool.paths, each.depth_m,
                       each.drag_distance_m))
      .add(bytes_of(tool.balls_m))
      .add({body.is_reachable.data(), body.is_reachable.size()})
      .hex();
}

std::string curves_fingerprint(const FitSection& fit, const std::filesystem::path& samples,
                               const std::filesystem::path& cycles) {
  ContentHash hash = stage_hash("curves").add(canonical(fit)).add_file(samples);
  if (!cycles.empty()) hash.add_file(cycles);
  return hash.hex();
}

std::string model_fingerprint(const std::filesystem::path& curves,
                              const std::filesystem::path& body,
                              const std::filesystem::path& surface,
                              const std::vector<std::filesystem::path>& coupling) {
  ContentHash hash = stage_hash("model").add_file(curves).add_file(body);
  if (!surface.empty()) hash.add_file(surface);
  for (const std::filesystem::path& file : coupling) hash.add_file(file);
  return hash.hex();
}

std::string asset_fingerprint(const ExportSection& section, const std::filesystem::path& model) {
  return stage_hash("asset").add(canonical(section)).add_file(model).hex();
}

std::string statement_fingerprint(const Scene& scene, const std::string& asset_fingerprint,
                                  const std::filesystem::path& body) {
  ContentHash hash = stage_hash("statement");
  hash.add(canonical(scene, Stage::validate)).add(canonical(scene, Stage::simulate));
  if (scene.tool) hash.add(std::to_string(scene.tool->held_out));
  return hash.add(asset_fingerprint).add_file(body).hex();
}

std::optional<std::string> stored_in_hdf5(const std::filesystem::path& path,
                                          const char* attribute) {
  try {
    const Attributes attributes = read_attributes(path);
    const auto found = attributes.find(attribute);
    if (found != attributes.end()) return found->second;
  } catch (const Error&) {  // missing or damaged: made anew
  }
  return std::nullopt;
}

std::optional<std::string> stored_in_asset(const std::filesystem::path& path) {
  try {
    return fingerprint_in(std::string(read_asset_file(path).meta_json()));
  } catch (const Error&) {
    return std::nullopt;
  }
}

std::optional<std::string> stored_in_json(const std::filesystem::path& path) {
  try {
    return fingerprint_in(read_whole_file(path));
  } catch (const Error&) {
    return std::nullopt;
  }
}

bool has_statement(const std::filesystem::path& asset) {
  try {
    const auto meta = nlohmann::json::parse(read_asset_file(asset).meta_json(), nullptr, false);
    return meta.is_object() && meta.contains("statement");
  } catch (const Error&) {
    return false;
  }
}

}  // namespace palpate::tools
