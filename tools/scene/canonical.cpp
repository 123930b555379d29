#include "tools/scene/canonical.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>

#include "libfem/materials/materials.hpp"
#include "libfit/core/error.hpp"
#include "libfit/io/atomic_file.hpp"
#include "tools/scene/fields.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {
namespace {

std::string hash_of_mesh(const SceneMesh& mesh) {
  return ContentHash()
      .add(bytes_of(mesh.vertices))
      .add(bytes_of(mesh.triangles))
      .add(bytes_of(mesh.tets))
      .add({mesh.is_painted.data(), mesh.is_painted.size()})
      .hex();
}

// The mesh that has been read for a region, if it takes one.
std::optional<SceneMesh> mesh_of(const Region& region) {
  if (const auto* solid = std::get_if<Solid>(&region)) {
    if (!solid->boundary) return SceneMesh{};
    return SceneMesh{solid->boundary->surface.vertices, solid->boundary->surface.triangles, {}, {}};
  }
  const auto* marked = std::get_if<Marked>(&region);
  if (!marked) return std::nullopt;
  if (!marked->part) return SceneMesh{};
  const PaintedPart& part = *marked->part;
  if (part.is_on_faces())
    return SceneMesh{part.surface().vertices, part.surface().triangles, {}, part.is_painted()};
  return SceneMesh{part.volume().nodes, {}, part.volume().tets, part.is_painted()};
}

template <class Numbers>
toml::array array_of(const Numbers& numbers) {
  toml::array out;
  for (const double number : numbers) out.push_back(number);
  return out;
}

/// How a text names files: for a fingerprint meshes count by what is in them, and every member has
/// a key of its own; a scene has names and its own keys.
enum class TextFor { fingerprint, scene };

/// Puts each member of the sections that it visits into a table; with a stage, that stage's alone.
class SceneWriter {
 public:
  explicit SceneWriter(TextFor text_for, std::optional<Stage> only = {})
      : text_for_(text_for), only_(only) {}

  template <class Section>
  void section(toml::table& table, const Section& section) {
    table_ = &table;
    visit(section, *this);
  }

  template <class Kind>
  void operator()(Stage stage, std::string_view key, double value, const Kind&) {
    if constexpr (std::is_same_v<Kind, MeshUnit>)
      put(stage, key, fmt::format("{} m", value));
    else
      put(stage, key, value);
  }
  template <class Kind>
  void operator()(Stage stage, std::string_view key, const std::vector<double>& value,
                  const Kind&) {
    put(stage, key, array_of(value));
  }
  template <class Value, class Kind>  // whole numbers, flags and texts
  void operator()(Stage stage, std::string_view key, const Value& value, const Kind&) {
    put(stage, key, value);
  }
  void operator()(Stage stage, std::string_view key, const std::filesystem::path& value, File) {
    put(stage, key, value.filename().string());
  }
  // test_points: a number, "vertices", "auto" or the name of a file.
  void operator()(Stage stage, std::string_view key, const std::optional<int>& value, PointCount) {
    if (value)
      put(stage, key, *value);
    else
      put(stage, key, "vertices");
  }
  void operator()(Stage stage, std::string_view, const std::optional<PlacementSection>& value,
                  PointCount) {
    if (!value) return;
    put(stage, "test_points", "auto");
    visit(*value, *this);
  }
  void operator()(Stage stage, std::string_view key,
                  const std::optional<std::filesystem::path>& value, PointCount) {
    if (value)
      put(stage, text_for_ == TextFor::scene ? "test_points" : key, value->filename().string());
  }
  template <class Value, class Kind>
  void operator()(Stage stage, std::string_view key, const std::optional<Value>& value,
                  const Kind& kind) {
    if (value) (*this)(stage, key, *value, kind);
  }
  template <class Kind>
  void operator()(Stage stage, std::string_view key, const Vec3& value, const Kind&) {
    put(stage, key, array_of(value));
  }
  void operator()(Stage stage, std::string_view key, const Points& value, Any) {
    toml::array rows;
    for (const auto& row : value.rowwise()) rows.push_back(array_of(row));
    if (!rows.empty()) put(stage, key, rows);
  }
  void operator()(Stage stage, std::string_view key, const Region& region, Any) {
    const toml::table table = table_of(region);
    if (!key.empty()) return put(stage, key, table);
    for (const auto& [name, node] : table) put(stage, name.str(), node);
  }
  void operator()(Stage stage, std::string_view key, const std::vector<Region>& value, Any) {
    toml::array regions;
    for (const Region& region : value) regions.push_back(table_of(region));
    if (!regions.empty()) put(stage, key, regions);
  }
  void operator()(Stage stage, std::string_view key, const fem::MaterialParameters& value, Any) {
    put(stage, key, table_of(value));
  }
  void operator()(Stage stage, std::string_view,
                  const std::map<std::string, std::vector<double>, std::less<>>& values, Any) {
    for (const auto& [key, numbers] : values) {
      if (numbers.size() == 1)
        put(stage, key, numbers.front());
      else
        put(stage, key, array_of(numbers));
    }
  }
  void operator()(Stage stage, std::string_view key, const Surface& mesh, Any) {
    if (text_for_ == TextFor::fingerprint && mesh.vertices.rows() > 0)
      put(stage, key, hash_of_mesh({mesh.vertices, mesh.triangles, {}, {}}));
  }

 private:
  template <class Value>
  void put(Stage stage, std::string_view key, Value&& value) {
    if (!only_ || *only_ == stage) table_->insert_or_assign(key, std::forward<Value>(value));
  }

  toml::table table_of(const Region& region) const {
    if (const auto* half = std::get_if<HalfSpace>(&region))
      return toml::table{{half->is_below ? "below" : "above",
                          toml::table{{"axis", std::string(1, static_cast<char>('x' + half->axis))},
                                      {"at", half->at_m}}}};
    if (const auto* box = std::get_if<Box>(&region))
      return toml::table{{"box", toml::array{array_of(box->low_m), array_of(box->high_m)}}};
    if (const auto* ball = std::get_if<Ball>(&region))
      return toml::table{{"sphere", toml::table{{"center", array_of(ball->center_m)},
                                                {"radius", ball->radius_m}}}};
    if (const auto* layer = std::get_if<Layer>(&region))
      return toml::table{{"thickness", layer->thickness_m}};
    if (text_for_ == TextFor::fingerprint)
      return toml::table{{std::holds_alternative<Solid>(region) ? "inside" : "marked",
                          hash_of_mesh(*mesh_of(region))}};
    if (const auto* solid = std::get_if<Solid>(&region))
      return toml::table{{"inside", solid->file.filename().string()}};
    return toml::table{{"group", std::get<Marked>(region).group}};
  }

  // Rows that have the value of a key left out are left out.
  static toml::table table_of(const fem::MaterialParameters& value) {
    toml::table table{{"law", value.law}};
    auto next = value.values.begin();
    for (const fem::ParameterRow& row : fem::find_law(value.law, "law").parameters) {
      if (value.values.end() - next < row.count) break;
      const std::vector<double> numbers(next, next + row.count);
      next += row.count;
      if (std::ranges::all_of(numbers, [&](double number) {
            return number == row.fallback || (std::isnan(number) && std::isnan(row.fallback));
          }))
        continue;
      if (row.count == 1)
        table.insert(row.name, numbers.front());
      else
        table.insert(row.name, array_of(numbers));
    }
    if (const fem::Softening& softening = value.softening; softening.is_any())
      table.insert(
          "softening",
          toml::table{{"r", softening.r}, {"m", softening.scale_Pa}, {"beta", softening.beta}});
    toml::array branches;
    for (Eigen::Index k = 0; k < value.relaxation.branches(); ++k)
      branches.push_back(toml::array{value.relaxation.share[k], value.relaxation.time_s[k]});
    if (!branches.empty()) table.insert("relaxation", branches);
    return table;
  }

  TextFor text_for_;
  std::optional<Stage> only_;
  toml::table* table_ = nullptr;
};

// toml++ writes numbers with 17 digits; here they have as many as they need.
std::string text_of(const toml::node& node) {
  if (const toml::table* table = node.as_table()) {
    std::vector<std::string> members;
    for (const auto& [key, value] : *table)
      members.push_back(fmt::format("{} = {}", key.str(), text_of(value)));
    return fmt::format("{{ {} }}", fmt::join(members, ", "));
  }
  if (const toml::array* array = node.as_array()) {
    std::vector<std::string> items;
    for (const toml::node& item : *array) items.push_back(text_of(item));
    return fmt::format("[{}]", fmt::join(items, ", "));
  }
  if (node.is_string()) return quoted(node.as_string()->get());
  if (node.is_boolean()) return node.as_boolean()->get() ? "true" : "false";
  return node.is_integer() ? fmt::format("{}", node.as_integer()->get())
                           : fmt::format("{}", node.as_floating_point()->get());
}

std::string members_of(const toml::table& table) {
  std::string lines;
  for (const auto& [key, value] : table)
    lines += fmt::format("{} = {}\n", key.str(), text_of(value));
  return lines;
}

// A line for each member, and then a section for each table.
std::string lines_of(const toml::table& table) {
  std::string lines, sections;
  for (const auto& [key, value] : table) {
    if (const toml::table* section = value.as_table())
      sections += fmt::format("[{}]\n{}", key.str(), members_of(*section));
    else
      lines += fmt::format("{} = {}\n", key.str(), text_of(value));
  }
  return lines + sections;
}

// Keys of every stage.
toml::table table_of_scene(const Scene& scene, SceneWriter writer) {
  toml::table root, body, experiments, fit;
  toml::array layers, inclusions, beds;
  writer.section(body, scene.body);
  writer.section(root, scene.material);
  for (const InclusionSection& section : scene.inclusions) {
    toml::table inclusion;
    writer.section(inclusion, section);
    if (toml::table* own = inclusion["material"].as_table();
        own && !own->contains("softening") && !own->contains("relaxation"))
      own->insert("softening", toml::table());  // else it would be the body's
    if (std::holds_alternative<Layer>(section.region))
      layers.insert(layers.begin(), inclusion);
    else
      inclusions.push_back(inclusion);
  }
  for (const BedSection& section : scene.beds) {
    toml::table bed;
    writer.section(bed, section);
    beds.push_back(bed);
  }
  writer.section(experiments, scene.experiments);
  writer.section(fit, scene.fit);
  root.insert("body", body);
  if (!layers.empty()) root.insert("layer", layers);
  if (!inclusions.empty()) root.insert("inclusion", inclusions);
  if (!beds.empty()) root.insert("bed", beds);
  root.insert("experiments", experiments);
  root.insert("fit", fit);
  return root;
}

void put_probe(const ProbeSection& probe, SceneWriter& writer, toml::table& table) {
  writer.section(table, probe.spec);
  if (!probe.mesh) return;
  table.insert("mesh", probe.mesh->filename().string());
  table.insert("length_unit", fmt::format("{} m", probe.mesh_unit_m));
}

// A tool as a scene has it: friction is that of [probe], and what moves a tool without balls is no
// key of it.
toml::table table_of_tool(const ToolSection& tool, bool is_listed, SceneWriter& writer) {
  toml::table table;
  writer.section(table, tool);
  put_probe(tool.probe, writer, table);
  table.erase("friction");
  table.erase("row");
  if (tool.row > 0) table.insert("balls", tool.row);
  if (tool.radius_m.empty()) table.erase("radii");
  if (!tool.has_balls()) table.erase("tilt");
  if (is_listed) {
    table.insert("points", tool.paths);
    table.erase("paths");
  } else {
    table.erase("name");
  }
  return table;
}

std::string scene_text(const Scene& scene) {
  SceneWriter writer(TextFor::scene);
  toml::table root = table_of_scene(scene, writer), probe;
  put_probe(scene.probe, writer, probe);
  root.insert("probe", probe);
  if (scene.tool) root.insert("tool", table_of_tool(*scene.tool, false, writer));
  toml::array pressed;
  for (const ToolSection& tool : scene.pressed)
    pressed.push_back(table_of_tool(tool, true, writer));
  if (!pressed.empty()) root["experiments"].as_table()->insert("probe", pressed);
  return lines_of(root);
}

template <class Section>
std::string canonical_section(const Section& section) {
  toml::table table;
  SceneWriter(TextFor::fingerprint).section(table, section);
  return members_of(table);
}

Region with_mesh(const Region& region, const SceneMesh& mesh) {
  if (mesh.vertices.rows() == 0) return region;
  if (const auto* solid = std::get_if<Solid>(&region))
    return Solid{solid->file,
                 std::make_shared<const Enclosed>(Surface{mesh.vertices, mesh.triangles})};
  Marked marked = std::get<Marked>(region);
  marked.part = mesh.tets.rows() > 0 ? std::make_shared<const PaintedPart>(
                                           TetMesh{mesh.vertices, mesh.tets, {}}, mesh.is_painted)
                                     : std::make_shared<const PaintedPart>(
                                           Surface{mesh.vertices, mesh.triangles}, mesh.is_painted);
  return marked;
}

}  // namespace

bool store_scene(const Scene& scene, Body& body) {
  std::vector<SceneMesh> meshes;
  visit_shapes(
      scene,
      [&](const Region& region) {
        if (auto mesh = mesh_of(region)) meshes.push_back(std::move(*mesh));
      },
      [&](const ProbeSection& probe) {
        if (probe.mesh)
          meshes.push_back({probe.spec.mesh.vertices, probe.spec.mesh.triangles, {}, {}});
      });
  std::string text = scene_text(scene);
  const bool is_same =
      text == body.scene && body.probe && canonical(*body.probe) == canonical(scene.probe.spec) &&
      std::ranges::equal(meshes, body.scene_meshes, {}, hash_of_mesh, hash_of_mesh);
  body.scene = std::move(text);
  body.scene_meshes = std::move(meshes);
  body.probe = scene.probe.spec;
  return !is_same;
}

Scene scene_of(const Body& body, const std::filesystem::path& path) {
  Scene scene = parse_scene(body.scene, path);
  auto next = body.scene_meshes.begin();
  const auto take = [&]() -> const SceneMesh& {
    if (next == body.scene_meshes.end())
      throw Error(path.string() + ": scene", "lacks a mesh that its text names",
                  "Make the body again with `palpate prepare`.");
    return *next++;
  };
  visit_shapes(
      scene,
      [&](Region& region) {
        if (mesh_of(region)) region = with_mesh(region, take());
      },
      [&](ProbeSection& probe) {
        if (!probe.mesh) return;
        const SceneMesh& mesh = take();
        probe.spec.mesh = {mesh.vertices, mesh.triangles};
      });
  if (body.probe) scene.probe.spec = *body.probe;
  resolve_probes(scene);
  return scene;
}

std::string canonical(const Scene& scene, Stage stage) {
  SceneWriter writer(TextFor::fingerprint, stage);
  toml::table root = table_of_scene(scene, writer), probe, validate;
  writer.section(probe, scene.probe.spec);
  writer.section(validate, scene.validate);
  root.insert("probe", probe);
  root.insert("validate", validate);
  return lines_of(root);
}

std::string canonical(const BodySection& section) { return canonical_section(section); }
std::string canonical(const FitSection& section) { return canonical_section(section); }
std::string canonical(const fem::MaterialParameters& material) {
  return canonical_section(std::optional(material));
}
std::string canonical(const ProbeSpec& probe) { return canonical_section(probe); }
std::string canonical(const ToolSection& tool) {
  return canonical_section(tool) + canonical(tool.probe.spec);
}

}  // namespace palpate::tools
