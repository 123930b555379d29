#include "tools/stages/fingerprint.hpp"

#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "libfit/assets/asset_file.hpp"
#include "libfit/core/error.hpp"
#include "libfit/io/atomic_file.hpp"
#include "libfit/io/files/files.hpp"
#include "tools/build_identity.hpp"
#include "tools/scene/canonical.hpp"

namespace palpate::tools {
namespace {

// The JSON of a file, or of an asset's meta; discarded where it is missing or damaged.
nlohmann::json json_in(const std::filesystem::path& path) {
  try {
    const std::string text = is_asset_file(path) ? std::string(read_asset_file(path).meta_json())
                                                 : read_whole_file(path);
    return nlohmann::json::parse(text, nullptr, false);
  } catch (const Error&) {
    return nlohmann::json::value_t::discarded;
  }
}

}  // namespace

ContentHash stage_hash(const char* stage) {
  ContentHash hash;
  hash.add(stage).add(build_identity());
  return hash;
}

std::string import_fingerprint() { return stage_hash("import").hex(); }

std::string body_fingerprint(const Scene& scene) {
  ContentHash hash = stage_hash("body");
  hash.add(canonical(scene, Stage::prepare));
  ProbeSpec shape = scene.probe.spec;  // what it reaches depends on the tool and how deep it goes
  shape.friction = 0;
  hash.add(canonical(shape)).add(fmt::format("{}", scene.experiments.each.depth_m));
  // What its beds leave of the region.
  if (!scene.beds.empty()) hash.add(canonical(scene, Stage::simulate));
  hash.add_file(scene.body.surface ? *scene.body.surface : *scene.body.tetmesh);
  if (scene.body.cavity) hash.add_file(*scene.body.cavity);
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

std::string tool_fingerprint(const Scene& scene, const std::vector<ToolSection>& others) {
  if (!scene.tool && others.empty()) return {};
  ContentHash hash = stage_hash("tool");
  if (scene.tool) hash.add(canonical(scene.tool->probe.spec));
  for (const ToolSection& other : others) hash.add(canonical(other.probe.spec));
  return hash.hex();
}

std::string samples_fingerprint(const Scene& scene, const Body& body) {
  ContentHash hash;
  hash.add(point_fingerprint(scene, body)).add(tool_fingerprint(scene, scene.pressed));
  for (const ToolSection& tool : scene.pressed) hash.add(std::to_string(tool.paths));
  hash.add(bytes_of(body.test_points.position)).add(bytes_of(body.test_points.normal));
  for (const std::string& name : body.test_points.name) hash.add(name);
  // Where experiments are drawn, and how many of which.
  hash.add({body.is_reachable.data(), body.is_reachable.size()});
  hash.add(fmt::format("{} {}", scene.experiments.cycles, scene.experiments.pairs));
  if (const auto& tool = scene.tool)
    hash.add(fmt::format("{} {} {}", tool->row, tool->tilt_rad, tool->paths))
        .add(bytes_of(tool->balls_m));
  if (!scene.experiments.placement) return hash.hex();
  hash.add(canonical(scene, Stage::place)).add(canonical(scene, Stage::fit));
  hash.add(bytes_of(body.test_points.triangles));
  return hash.hex();
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

std::optional<std::string> stored_in_json(const std::filesystem::path& path) {
  const auto json = json_in(path);
  if (!json.is_object() || !json.contains(kInputsAttribute) || !json[kInputsAttribute].is_string())
    return std::nullopt;
  return json[kInputsAttribute].get<std::string>();
}

bool has_statement(const std::filesystem::path& asset) {
  const auto meta = json_in(asset);
  return meta.is_object() && meta.contains("statement");
}

}  // namespace palpate::tools
