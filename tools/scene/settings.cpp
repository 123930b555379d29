#include "tools/scene/settings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "tools/scene/settings_reader.hpp"
#include "tools/scene/settings_writer.hpp"

namespace palpate::tools {
namespace {

constexpr const char* kGravityPrefix = "gravity/";
constexpr const char* kToolPrefix = "tool/";
std::string pressed_prefix(std::size_t i) { return fmt::format("pressed/{}/", i); }
std::string inclusion_prefix(std::size_t i) { return fmt::format("inclusion/{}/", i); }
std::string bed_prefix(std::size_t i) { return fmt::format("bed/{}/", i); }

void write_scene(const Scene& scene, SettingsWriter& writer) {
  writer.section("body/", scene.body);
  writer.section("", scene.material);
  for (std::size_t i = 0; i < scene.inclusions.size(); ++i)
    writer.section(inclusion_prefix(i), scene.inclusions[i]);
  for (std::size_t i = 0; i < scene.beds.size(); ++i) writer.section(bed_prefix(i), scene.beds[i]);
  if (scene.gravity) writer.section(kGravityPrefix, *scene.gravity);
  writer.section("experiments/", scene.experiments);
  writer.section("fit/", scene.fit);
}

void write_tool(const ToolSection& tool, const std::string& prefix, SettingsWriter& writer) {
  writer.section(prefix, tool);
  writer.section(prefix + "probe/", tool.probe.spec);
}
ToolSection tool_of(SettingsReader& reader, const std::string& prefix) {
  ToolSection tool = reader.section<ToolSection>(prefix);
  tool.probe.spec = reader.section<ProbeSpec>(prefix + "probe/");
  return tool;
}

template <class Section>
std::string canonical_section(const Section& section) {
  SettingsWriter writer;
  writer.section("", section);
  return canonical(writer.settings());
}

}  // namespace

Settings settings_of(const Scene& scene) {
  SettingsWriter writer;
  write_scene(scene, writer);
  if (scene.tool) write_tool(*scene.tool, kToolPrefix, writer);
  for (std::size_t i = 0; i < scene.pressed.size(); ++i)
    write_tool(scene.pressed[i], pressed_prefix(i), writer);
  return writer.settings();
}

Scene scene_of(const Body& body, const std::filesystem::path& path) {
  Scene scene;
  scene.path = path;
  SettingsReader reader(body.settings, path.string());
  scene.body = reader.section<BodySection>("body/");
  scene.material = reader.section<std::optional<fem::MaterialParameters>>("");
  for (std::size_t i = 0; reader.has_section(inclusion_prefix(i)); ++i)
    scene.inclusions.push_back(reader.section<InclusionSection>(inclusion_prefix(i)));
  for (std::size_t i = 0; reader.has_section(bed_prefix(i)); ++i)
    scene.beds.push_back(reader.section<BedSection>(bed_prefix(i)));
  if (reader.has_section(kGravityPrefix))
    scene.gravity = reader.section<GravitySection>(kGravityPrefix);
  if (body.probe) scene.probe.spec = *body.probe;
  scene.experiments = reader.section<ExperimentsSection>("experiments/");
  scene.fit = reader.section<FitSection>("fit/");
  if (reader.has_section(kToolPrefix)) scene.tool = tool_of(reader, kToolPrefix);
  for (std::size_t i = 0; reader.has_section(pressed_prefix(i)); ++i)
    scene.pressed.push_back(tool_of(reader, pressed_prefix(i)));
  return scene;
}

std::string canonical(const Settings& settings) {
  std::string text;
  for (const auto& [key, setting] : settings)
    text += setting.unit.empty()
                ? fmt::format("{} = \"{}\"\n", key, setting.text)
                : fmt::format("{} = {} {}\n", key, fmt::join(setting.numbers, " "), setting.unit);
  return text;
}

std::string canonical(const Scene& scene, Stage stage) {
  SettingsWriter writer(stage);
  write_scene(scene, writer);
  writer.section("probe/", scene.probe.spec);
  writer.section("export/", scene.export_);
  writer.section("validate/", scene.validate);
  return canonical(writer.settings());
}

std::string canonical(const BodySection& section) { return canonical_section(section); }
std::string canonical(const FitSection& section) { return canonical_section(section); }
std::string canonical(const ExportSection& section) { return canonical_section(section); }
std::string canonical(const ProbeSpec& probe) { return canonical_section(probe); }
std::string canonical(const ToolSection& tool) {
  SettingsWriter writer;
  write_tool(tool, "", writer);
  return canonical(writer.settings());
}

}  // namespace palpate::tools
