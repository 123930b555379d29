#include "tools/scene/scene.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "libfit/core/error.hpp"
#include "libfit/io/atomic_file.hpp"
#include "tools/scene/fields.hpp"
#include "tools/scene/toml_table.hpp"

namespace palpate::tools {
namespace {

// A part of the body relaxes and softens as the body does unless it says how.
fem::MaterialParameters read_part_material(SceneTable& table,
                                           const std::optional<fem::MaterialParameters>& body) {
  const SceneTable own = table.table("material", "");
  auto material = read_material(table.table("material", "material of " + table.name()), true);
  if (!own.holds("relaxation") && !own.holds("softening") && body) {
    material.relaxation = body->relaxation;
    material.softening = body->softening;
  }
  table.finish();
  return material;
}

// Layers are the first inclusions, the deepest first, for the last one named counts.
std::vector<InclusionSection> read_inclusions(SceneTable& root, const std::filesystem::path& scene,
                                              const std::optional<fem::MaterialParameters>& body) {
  std::vector<InclusionSection> inclusions;
  Layer layer;
  for (SceneTable& table : root.tables("layer", "[[layer]]")) {
    layer.above_m = layer.depth_m();
    layer.thickness_m =
        table.required_quantity("thickness", Dimension::length, kSmallestLength, kAnyLength);
    inclusions.insert(inclusions.begin(), {layer, read_part_material(table, body)});
  }
  for (SceneTable& table : root.tables("inclusion", "[[inclusion]]")) {
    const Region region = take_region(table, scene);
    inclusions.push_back({region, read_part_material(table, body)});
  }
  return inclusions;
}

std::vector<BedSection> read_beds(SceneTable& root, const std::filesystem::path& scene) {
  std::vector<BedSection> beds;
  for (SceneTable& table : root.tables("bed", "[[bed]]")) {
    BedSection bed;
    bed.region = take_region(table, scene);
    bed.material = read_material(table.table("material", "material of [[bed]]"));
    bed.thickness_m =
        table.required_quantity("thickness", Dimension::length, kSmallestLength, kAnyLength);
    bed.slides = table.boolean("slides", false);
    table.finish();
    beds.push_back(bed);
  }
  return beds;
}

// Reads each member of a section from the key that names it; a key left out leaves the default.
class SectionReader {
 public:
  SectionReader(SceneTable& table, const std::filesystem::path& scene)
      : table_(table), scene_(scene) {}

  void operator()(Stage, std::string_view key, double& value, Length) {
    value = length(key, value);
  }
  void operator()(Stage, std::string_view key, std::optional<double>& value, Length) {
    if (table_.has(key)) value = length(key, 0);
  }
  void operator()(Stage, std::string_view key, std::vector<double>& value, Length) {
    if (table_.has(key))
      value = table_.quantities(key, Dimension::length, kSmallestLength, kAnyLength);
  }
  void operator()(Stage, std::string_view key, double& value, Duration) {
    value = table_.quantity(key, Dimension::time, value, 0, runtime::kMaxRelaxation_s);
  }
  void operator()(Stage, std::string_view key, double& value, Pressure) {
    value = table_.quantity(key, Dimension::pressure, value, 0, 1e6);
  }
  void operator()(Stage, std::string_view key, double& value, Tilt) {
    value = table_.quantity(key, Dimension::angle, value, 0, kMostTilt_rad);
  }
  void operator()(Stage, std::string_view key, std::vector<double>& value, Speed) {
    if (!table_.has(key)) return;
    value = table_.quantities(key, Dimension::speed, 1e-9, 100);  // m/s; a tool in tissue
    if (value.empty())
      throw Error(table_.where(key), fmt::format("{} names no speed", name_of(key)),
                  "Give one or more, or leave the key out.");
  }
  void operator()(Stage, std::string_view key, double& value, const Number& may) {
    value = table_.number(key, value, may.low, may.high);
  }
  void operator()(Stage, std::string_view key, int& value, const Whole& may) {
    value = static_cast<int>(table_.integer(key, value, may.low, may.high));
  }
  void operator()(Stage, std::string_view key, bool& value, Any) {
    value = table_.boolean(key, value);
  }
  void operator()(Stage, std::string_view key, std::string& value, const Choice& may) {
    value = table_.choice(key, value, may.names);
  }
  void operator()(Stage, std::string_view key, std::optional<std::filesystem::path>& value, File) {
    if (table_.has(key)) value = file_beside(scene_, table_.text(key, ""));
  }
  void operator()(Stage, std::string_view, double& value, MeshUnit) {
    value = table_.length_unit();
  }
  void operator()(Stage, std::string_view key, std::vector<Region>& value, Any) {
    for (SceneTable& region : table_.tables(key, name_of(key)))
      value.push_back(read_region(std::move(region), scene_));
  }
  void operator()(Stage, std::string_view key, std::optional<Region>& value, Any) {
    if (table_.has(key)) value = read_region(table_.table(key, name_of(key)), scene_);
  }
  // test_points: a number, "vertices", "auto", or else a file of points.
  void operator()(Stage, std::string_view, std::optional<int>& value, PointCount) {
    const toml::node* node = table_.node("test_points");
    if (node != nullptr && node->is_integer())
      value = static_cast<int>(table_.integer("test_points", 0, 4, 1000000));
    else if (const auto word = point_word())
      value = *word == "auto" ? std::optional<int>(kFirstPoints) : std::nullopt;
  }
  void operator()(Stage, std::string_view, std::optional<PlacementSection>& value, PointCount) {
    if (point_word() == "auto") visit(value.emplace(), *this);
  }
  void operator()(Stage, std::string_view, std::optional<std::filesystem::path>& value,
                  PointCount) {
    const auto word = point_word();
    if (word && *word != "auto" && *word != "vertices") value = file_beside(scene_, *word);
  }

 private:
  double length(std::string_view key, double fallback) {
    return table_.quantity(key, Dimension::length, fallback, kSmallestLength, kAnyLength);
  }
  std::string name_of(std::string_view key) const {
    return fmt::format("{} of {}", key, table_.name());
  }
  std::optional<std::string> point_word() {
    const toml::node* node = table_.node("test_points");
    if (node == nullptr || node->is_integer()) return std::nullopt;
    return table_.text("test_points", "");
  }

  SceneTable& table_;
  const std::filesystem::path& scene_;
};

template <class Section>
Section read_section(SceneTable& table, const std::filesystem::path& scene) {
  Section section;
  SectionReader reader(table, scene);
  visit(section, reader);
  return section;
}

template <class Section>
Section read_section(SceneTable&& table, const std::filesystem::path& scene) {
  const Section section = read_section<Section>(table, scene);
  table.finish();
  return section;
}

BodySection read_body(SceneTable table, const std::filesystem::path& scene) {
  if (table.has("surface") == table.has("tetmesh"))
    throw Error(table.where_table(),
                table.has("surface") ? "[body] has both surface and tetmesh"
                                     : "[body] has neither surface nor tetmesh",
                "Give exactly one: surface = \"liver.obj\" or tetmesh = \"liver.msh\".");
  const std::string where = table.where_table();
  const BodySection body = read_section<BodySection>(std::move(table), scene);
  if ((body.wall_m || body.cavity) && body.tetmesh)
    throw Error(where, "wall and cavity hollow a surface out, and the body is a tetmesh",
                "Leave them out, or give the surface.");
  if (body.wall_m && body.cavity)
    throw Error(where, "[body] has both wall and cavity",
                "Give one: each makes the inner surface.");
  return body;
}

ExperimentsSection read_experiments(SceneTable table, const std::filesystem::path& scene) {
  ExperimentsSection out = read_section<ExperimentsSection>(table, scene);
  // A key of another way to place points is named for what it is.
  for (const char* key : {"tolerance", "budget"})
    if (!out.placement && table.has(key))
      throw Error(
          table.where(key),
          fmt::format(
              "{} of [experiments] places test points, and test_points is a number or a file", key),
          fmt::format("Set test_points = \"auto\", or leave {} out.", key));
  Experiments& each = out.each;
  if (!table.has("drag_depths")) each.drag_depths_m = {0.4 * each.depth_m, 0.8 * each.depth_m};
  for (const double depth : each.drag_depths_m)
    if (depth > each.depth_m)
      throw Error(table.where("drag_depths"),
                  fmt::format("drag_depths of [experiments] holds {} m, deeper than depth ({} m)",
                              depth, each.depth_m),
                  "Drags start from a press: make depth at least the deepest drag.");
  std::vector<double> sorted = each.drag_depths_m;
  std::sort(sorted.begin(), sorted.end());
  if (const auto twice = std::adjacent_find(sorted.begin(), sorted.end()); twice != sorted.end())
    throw Error(table.where("drag_depths"),
                fmt::format("drag_depths of [experiments] holds {} m twice", *twice),
                "Name each depth once.");
  table.finish();
  return out;
}

}  // namespace

FitSection read_fit(SceneTable table, const std::filesystem::path& path) {
  return read_section<FitSection>(std::move(table), path);
}

std::string probe_place(const Scene& scene) { return scene.path.string() + ": [probe]"; }
std::string tool_place(const Scene& scene, const ToolSection& tool) {
  return fmt::format("{}: tool `{}`", scene.path.string(), tool.name);
}

std::string name_of_part(const Scene& scene, std::size_t i) {
  const auto layers = static_cast<std::size_t>(std::ranges::count_if(
      scene.inclusions,
      [](const InclusionSection& part) { return std::holds_alternative<Layer>(part.region); }));
  return i < layers ? fmt::format("[[layer]] {}", layers - i)
                    : fmt::format("[[inclusion]] {}", i - layers + 1);
}

void resolve_probes(Scene& scene) {
  const auto resolve = [](ProbeSection& probe, const std::string& where) {
    const bool is_unread = probe.mesh && probe.spec.mesh.triangles.rows() == 0;
    if (probe.spec.shape != "point" && !is_unread) probe.rigid = fem::make_probe(probe.spec, where);
  };
  resolve(scene.probe, probe_place(scene));
  if (scene.tool) resolve(scene.tool->probe, tool_place(scene, *scene.tool));
  for (ToolSection& tool : scene.pressed) resolve(tool.probe, tool_place(scene, tool));
  for (ToolSection& tool : scene.stated) resolve(tool.probe, tool_place(scene, tool));
}

const fem::Probe& rigid_probe(const Scene& scene) {
  if (!scene.probe.rigid)
    throw Error(probe_place(scene), "a " + scene.probe.spec.shape + " cannot be simulated",
                "Give [probe] a shape, such as \"sphere\".");
  return *scene.probe.rigid;
}

Scene parse_scene(const std::string& text, const std::filesystem::path& path,
                  std::vector<Error>* errors) {
  if (text.find('\0') != std::string::npos)  // no text has one; assets and HDF5 files do
    throw Error(path.string(), "is no text",
                "Name a scene, such as `palpate new` writes; `palpate inspect` says what it is.");
  const toml::table parsed = parse_toml(
      text, path.string(),
      "Mend the TOML at this place, or name a scene: a text such as `palpate new` writes.");
  const auto section = [&](auto&& read) {
    try {
      read();
    } catch (const Error& e) {
      if (errors == nullptr) throw;
      errors->push_back(e);
    }
  };
  Scene scene;
  scene.path = path;
  SceneTable root(parsed, "the scene", path.string());
  section([&] {
    if (!root.has("body"))
      throw root.has("recording")
          ? Error(path.string(), "is a manifest of recordings, and no scene",
                  "Name a scene.toml; `palpate run` and `check` read both.")
          : Error(path.string(), "the scene has no [body]",
                  "Add [body] with surface and length_unit.");
    scene.body = read_body(root.table("body", "[body]"), path);
  });
  section([&] {
    if (root.has("material"))
      scene.material = read_material(root.table("material", "[material]"), true);
  });
  section([&] { scene.inclusions = read_inclusions(root, path, scene.material); });
  section([&] { scene.beds = read_beds(root, path); });
  section([&] {
    SceneTable probe = root.table("probe", "[probe]");
    scene.probe = read_probe(probe, path.parent_path());
  });
  section([&] {
    if (!root.has("tool")) return;
    SceneTable tool = root.table("tool", "[tool]");
    scene.tool = read_tool(tool, path.parent_path(), scene.probe.spec.friction);
  });
  section([&] {
    SceneTable experiments = root.table("experiments", "[experiments]");
    scene.pressed = read_tools(experiments, "probe", path.parent_path(), scene.probe.spec.friction,
                               4, &ToolSection::paths);
    scene.experiments = read_experiments(std::move(experiments), path);
  });
  section([&] { scene.fit = read_fit(root.table("fit", "[fit]"), path); });
  section([&] {
    SceneTable validate = root.table("validate", "[validate]");
    scene.stated = read_tools(validate, "tool", path.parent_path(), scene.probe.spec.friction, 10,
                              &ToolSection::held_out);
    scene.validate = read_section<ValidateSection>(std::move(validate), path);
  });
  section([&] { root.finish(); });
  if (errors == nullptr || errors->empty()) section([&] { resolve_probes(scene); });
  return scene;
}

void make_quick(Scene& scene) {
  ExperimentsSection& experiments = scene.experiments;
  auto& placement = experiments.placement;
  if (placement) placement->budget = std::min(placement->budget, 60);
  if (!experiments.points_file)
    experiments.test_points =
        std::min(experiments.test_points.value_or(kFirstPoints), kFirstPoints);
  Experiments& each = experiments.each;
  each.press_steps = std::min(each.press_steps, 5);
  each.drag_steps = std::min(each.drag_steps, 5);
  each.drag_directions = std::min(each.drag_directions, 1);
  if (!placement && each.drag_depths_m.size() > 1)
    each.drag_depths_m = {*std::max_element(each.drag_depths_m.begin(), each.drag_depths_m.end())};
  scene.validate.points = std::min(scene.validate.points, 6);
  scene.validate.causes = false;
  for (ToolSection& tool : scene.stated) tool.held_out = std::min(tool.held_out, 5);
  if (!scene.tool) return;
  scene.tool->paths = std::min(scene.tool->paths, 5);
  scene.tool->held_out = std::min(scene.tool->held_out, 5);
}

Scene read_scene(const std::filesystem::path& path) {
  return parse_scene(read_whole_file(path), path);
}

}  // namespace palpate::tools
