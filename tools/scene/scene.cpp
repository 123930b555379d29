#include "tools/scene/scene.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <fstream>
#include <iterator>
#include <limits>
#include <sstream>

#include "libfem/elements/elements.hpp"
#include "libfit/core/curves.hpp"
#include "libfit/fit/neighbours/smoothing_report.hpp"
#include "tools/scene/material.hpp"
#include "tools/scene/toml_table.hpp"

namespace palpate::tools {
namespace {

constexpr double kAnyLength = 1e6;        // m; beyond it the unit is wrong
constexpr double kSmallestLength = 1e-9;  // m
constexpr long kMaxPoints = 10000;        // as many as can be triangulated
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

std::filesystem::path beside(const std::filesystem::path& scene, const std::string& name) {
  const std::filesystem::path path(name);
  return std::filesystem::absolute(path.is_absolute() ? path : scene.parent_path() / path)
      .lexically_normal();
}

HalfSpace read_half_space(SceneTable table, bool is_below) {
  static const std::vector<std::string_view> kAxes{"x", "y", "z"};
  HalfSpace half;
  half.is_below = is_below;
  half.axis = table.choice("axis", "z", kAxes)[0] - 'x';
  half.at_m = table.required_quantity("at", Dimension::length, -kAnyLength, kAnyLength);
  table.finish();
  return half;
}

Ball read_ball(SceneTable table) {
  Ball ball;
  ball.center_m = table.point("center");
  ball.radius_m = table.required_quantity("radius", Dimension::length, kSmallestLength, kAnyLength);
  table.finish();
  return ball;
}

Box read_box(SceneTable& table) {
  const auto [low, high] = table.corners("box");
  if (!(low.array() < high.array()).all())
    throw Error(table.where("box"), "box of " + table.name() + " is empty",
                "Give the lower corner first: every coordinate of the second must be larger.");
  return {low, high};
}

// The one region a table names; nothing when it names none.
std::optional<Region> find_region(SceneTable& table) {
  std::optional<Region> region;
  int named = 0;
  if (table.has("below")) {
    ++named;
    region = read_half_space(table.table("below", "below"), true);
  }
  if (table.has("above")) {
    ++named;
    region = read_half_space(table.table("above", "above"), false);
  }
  if (table.has("sphere")) {
    ++named;
    region = read_ball(table.table("sphere", "sphere"));
  }
  if (table.has("box")) {
    ++named;
    region = read_box(table);
  }
  if (named > 1)
    throw Error(table.where_table(), table.name() + " names more than one region",
                "Keep one of below, above, box, sphere.");
  return region;
}

Region read_region(SceneTable table) {
  const auto region = find_region(table);
  if (!region)
    throw Error(table.where_table(), table.name() + " names no region",
                "Give one of below, above, box, sphere.");
  table.finish();
  return *region;
}

BodySection read_body(SceneTable table, const std::filesystem::path& scene) {
  std::vector<std::string_view> elements;
  for (const fem::ElementRow& row : fem::kElements) elements.push_back(row.name);
  BodySection body;
  if (table.has("surface")) body.surface = beside(scene, table.text("surface", ""));
  if (table.has("tetmesh")) body.tetmesh = beside(scene, table.text("tetmesh", ""));
  if (body.surface.has_value() == body.tetmesh.has_value())
    throw Error(table.where_table(),
                body.surface ? "[body] has both surface and tetmesh"
                             : "[body] has neither surface nor tetmesh",
                "Give exactly one: surface = \"liver.obj\" or tetmesh = \"liver.msh\".");
  body.length_unit_m = table.length_unit();
  body.element = table.choice("element", body.element, elements);
  for (SceneTable& region : table.tables("fixed", "fixed of [body]"))
    body.fixed.push_back(read_region(std::move(region)));
  if (table.has("mesh_size"))
    body.mesh_size_m =
        table.required_quantity("mesh_size", Dimension::length, kSmallestLength, kAnyLength);
  if (table.has("wrap"))
    body.wrap_m = table.required_quantity("wrap", Dimension::length, kSmallestLength, kAnyLength);
  table.finish();
  return body;
}

std::vector<InclusionSection> read_inclusions(SceneTable& root) {
  std::vector<InclusionSection> inclusions;
  for (SceneTable& table : root.tables("inclusion", "[[inclusion]]")) {
    InclusionSection inclusion;
    const auto region = find_region(table);
    if (!region)
      throw Error(table.where_table(), "[[inclusion]] names no region",
                  "Give it one of sphere, box, below, above.");
    inclusion.region = *region;
    inclusion.material = read_material(table.table("material", "material of [[inclusion]]"));
    table.finish();
    inclusions.push_back(inclusion);
  }
  return inclusions;
}

void read_test_points(SceneTable& table, const std::filesystem::path& scene,
                      ExperimentsSection& out) {
  const toml::node* value = table.node("test_points");
  if (!value) return;
  if (value->is_integer()) {
    out.test_points = static_cast<int>(table.integer("test_points", 0, 4, 1000000));
    return;
  }
  const std::string text = table.text("test_points", "");
  out.test_points.reset();
  if (text == "vertices") return;
  if (text == "auto") {
    PlacementSection placement;
    placement.tolerance = table.number("tolerance", placement.tolerance, 0, 1);
    placement.budget =
        static_cast<int>(table.integer("budget", placement.budget, kFirstPoints, kMaxPoints));
    out.placement = placement;
    out.test_points = kFirstPoints;
    return;
  }
  out.points_file = beside(scene, text);
}

ExperimentsSection read_experiments(SceneTable table, const std::filesystem::path& scene) {
  ExperimentsSection out;
  read_test_points(table, scene, out);
  if (table.has("region"))
    out.region = read_region(table.table("region", "region of [experiments]"));
  out.depth_m =
      table.quantity("depth", Dimension::length, out.depth_m, kSmallestLength, kAnyLength);
  out.press_steps = static_cast<int>(table.integer("press_steps", out.press_steps, 1, 1000));
  out.drag_depths_m =
      table.has("drag_depths")
          ? table.quantities("drag_depths", Dimension::length, kSmallestLength, kAnyLength)
          : std::vector<double>{0.4 * out.depth_m, 0.8 * out.depth_m};
  for (const double depth : out.drag_depths_m)
    if (depth > out.depth_m)
      throw Error(table.where("drag_depths"),
                  fmt::format("drag_depths of [experiments] holds {} m, deeper than depth ({} m)",
                              depth, out.depth_m),
                  "Drags start from a press: make depth at least the deepest drag.");
  out.drag_distance_m = table.quantity("drag_distance", Dimension::length, out.drag_distance_m,
                                       kSmallestLength, kAnyLength);
  out.drag_directions =
      static_cast<int>(table.integer("drag_directions", out.drag_directions, 0, 360));
  out.drag_steps = static_cast<int>(table.integer("drag_steps", out.drag_steps, 1, 1000));
  out.force_tolerance = table.number("force_tolerance", out.force_tolerance, 0, 1);
  table.finish();
  return out;
}

FitSection read_fit(SceneTable table) {
  std::vector<std::string_view> families{"auto"};
  for (const CurveFamilyName& row : kCurveFamilyNames) families.push_back(row.name);
  FitSection fit;
  fit.family = table.choice("family", fit.family, families);
  fit.degree = static_cast<int>(table.integer("degree", fit.degree, 0, 4));
  fit.pieces = static_cast<int>(table.integer("pieces", fit.pieces, 0, 256));
  fit.tolerance = table.number("tolerance", fit.tolerance, 1e-6, 1);
  const toml::node* smoothing = table.node("smoothing");
  if (smoothing != nullptr && smoothing->is_number())
    fit.smoothing = table.number("smoothing", 0, 0, kStrongestSmoothing);
  else if (table.choice("smoothing", "auto", {"auto", "none"}) == "none")
    fit.smoothing = 0;
  table.finish();
  return fit;
}

ExportSection read_export(SceneTable table) {
  static const std::vector<std::string_view> kPrecisions{"float32"}, kRepairs{"none"};
  ExportSection out;
  out.precision = table.choice("precision", out.precision, kPrecisions);
  out.guard = table.boolean("guard", out.guard);
  out.repair = table.choice("repair", out.repair, kRepairs);
  table.finish();
  return out;
}

ValidateSection read_validate(SceneTable table) {
  ValidateSection out;
  out.points = static_cast<int>(table.integer("points", out.points, 1, 100000));
  out.seed = static_cast<int>(table.integer("seed", out.seed, 0, 1 << 30));
  out.causes = table.boolean("causes", out.causes);
  table.finish();
  return out;
}

}  // namespace

Scene parse_scene(const std::string& text, const std::filesystem::path& path) {
  toml::table parsed;
  try {
    parsed = toml::parse(text, path.string());
  } catch (const toml::parse_error& e) {
    throw Error(
        fmt::format("{}:{}:{}", path.string(), e.source().begin.line, e.source().begin.column),
        std::string(e.description()), "Mend the TOML at this place.");
  }
  Scene scene;
  scene.path = path;
  scene.text = text;
  SceneTable root(parsed, "the scene", path.string());
  if (!root.has("body"))
    throw Error(path.string(), "the scene has no [body]",
                "Add [body] with surface and length_unit.");
  scene.body = read_body(root.table("body", "[body]"), path);
  if (root.has("material")) scene.material = read_material(root.table("material", "[material]"));
  scene.inclusions = read_inclusions(root);
  SceneTable probe = root.table("probe", "[probe]");
  scene.probe = read_probe(probe, path.parent_path());
  scene.experiments = read_experiments(root.table("experiments", "[experiments]"), path);
  scene.fit = read_fit(root.table("fit", "[fit]"));
  scene.export_ = read_export(root.table("export", "[export]"));
  scene.validate = read_validate(root.table("validate", "[validate]"));
  root.finish();
  return scene;
}

Scene read_scene(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file)
    throw Error(path.string(), "the scene cannot be read", "Check the name and the permissions.");
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  return parse_scene(text, path);
}

std::string canonical_body(const Scene& scene) {
  std::string out =
      fmt::format("unit {} mesh_size {} wrap {}\n", scene.body.length_unit_m,
                  scene.body.mesh_size_m.value_or(kNone), scene.body.wrap_m.value_or(kNone));
  for (const Region& region : scene.body.fixed) out += "fixed " + canonical(region) + "\n";
  const auto& e = scene.experiments;
  out += fmt::format("test_points {} {}\n", e.test_points.value_or(-1),
                     e.points_file ? e.points_file->string() : "-");
  if (e.region) out += "region " + canonical(*e.region) + "\n";
  return out + fmt::format("probe {}\n", recorded_radius_m(scene.probe));
}

std::string canonical_point(const Scene& scene) {
  std::string out = "element " + scene.body.element + "\n";
  if (scene.material) out += "material " + canonical(*scene.material);
  for (const auto& inclusion : scene.inclusions)
    out += "inclusion " + canonical(inclusion.region) + " " + canonical(inclusion.material);
  const auto& e = scene.experiments;
  return out +
         fmt::format("probe {}\npress {} {}\ndrag {} {} {} {}\n", canonical(scene.probe), e.depth_m,
                     e.press_steps, fmt::join(e.drag_depths_m, " "), e.drag_distance_m,
                     e.drag_directions, e.drag_steps) +
         (e.force_tolerance > 0 ? fmt::format("error {}\n", e.force_tolerance) : "");
}

std::string canonical_experiments(const Scene& scene) {
  const auto& placement = scene.experiments.placement;
  return canonical_point(scene) +
         (placement ? fmt::format("auto {} {}\n", placement->tolerance, placement->budget) : "");
}

std::string canonical_fit(const Scene& scene) {
  return fmt::format("{} {} {} {} smoothing {}\n", scene.fit.family, scene.fit.degree,
                     scene.fit.pieces, scene.fit.tolerance, scene.fit.smoothing.value_or(kNone));
}

std::string canonical_export(const Scene& scene) {
  return fmt::format("{} {} {}\n", scene.export_.precision, scene.export_.guard,
                     scene.export_.repair);
}

std::string canonical_validate(const Scene& scene) {
  return fmt::format("{} {} {}\n", scene.validate.points, scene.validate.seed,
                     scene.validate.causes);
}

}  // namespace palpate::tools
