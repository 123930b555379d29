#include "tools/scene/probe.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "libfem/probes/probes.hpp"
#include "libfit/runtime/series/root.hpp"
#include "tools/scene/fields.hpp"
#include "tools/scene/nearest_name.hpp"
#include "tools/scene/toml_table.hpp"

namespace palpate::tools {
namespace {

constexpr double kSmallestLength = 1e-9, kAnyLength = 1e6;  // m
constexpr double kFullTurn_rad = 6.283185307179586;

std::vector<double> read_values(SceneTable& table, const fem::ProbeParameter& parameter) {
  const double low = parameter.dimension == Dimension::length ? kSmallestLength : 0;
  const double high = parameter.dimension == Dimension::length ? kAnyLength : kFullTurn_rad;
  return {table.quantity(parameter.key, parameter.dimension, 0, low, high)};
}

/// "upright" and "lying", or three numbers.
Vec3 read_orientation(SceneTable& table) {
  if (!table.node("orientation")->is_string()) return table.direction("orientation");
  const std::string word = table.choice("orientation", "upright", {"upright", "lying"});
  return word == "lying" ? Vec3::UnitX() : Vec3::UnitZ();
}

}  // namespace

ProbeSection read_probe(SceneTable& table, const std::filesystem::path& folder) {
  ProbeSection probe;
  ProbeSpec& spec = probe.spec;
  spec.shape = table.text("shape", spec.shape);
  if (const std::string remedy = remedy_of_former("shape", spec.shape); !remedy.empty())
    throw Error(table.where("shape"), fmt::format("there is no shape \"{}\"", spec.shape), remedy);
  if (spec.shape != "sphere") spec.values.clear();
  spec.friction = table.number("friction", spec.friction, 0, 100);
  if (spec.shape == "point") {
    table.finish();
    return probe;
  }
  const fem::ShapeRow& row =
      fem::find_shape(spec.shape, table.where("shape") + ": " + table.name() + " shape");
  const std::vector<std::string_view> own = fem::probe_keys(row);
  for (const fem::ShapeRow& other : fem::probe_shapes())
    for (const std::string_view key : fem::probe_keys(other)) {
      if (std::find(own.begin(), own.end(), key) == own.end() && table.holds(key))
        fem::refuse_probe_key(row, key, table.where(key) + ": " + table.name());
    }
  for (const fem::ProbeParameter& parameter : row.parameters)
    if (table.has(parameter.key))
      spec.values[std::string(parameter.key)] = read_values(table, parameter);
  if (!row.is_axisymmetric && table.has("orientation")) spec.orientation = read_orientation(table);
  if (row.takes_mesh) {
    if (!table.has("mesh"))
      throw Error(table.where_table(), table.name() + " has no mesh",
                  "Add mesh = \"tool.stl\" and length_unit = \"mm\".");
    const std::filesystem::path file(table.text("mesh", ""));
    probe.mesh =
        std::filesystem::absolute(file.is_absolute() ? file : folder / file).lexically_normal();
    probe.mesh_unit_m = table.length_unit();
  }
  table.finish();
  return probe;
}

namespace {

void read_balls(SceneTable& table, ToolSection& tool) {
  if (table.node("balls")->is_integer())
    tool.row = static_cast<int>(table.integer("balls", 0, 2, runtime::kMaxContacts));
  else
    tool.balls_m = table.points("balls");
  const Eigen::Index balls = tool.row > 0 ? tool.row : tool.balls_m.rows();
  if (balls < 1 || balls > runtime::kMaxContacts)
    throw Error(table.where("balls"),
                fmt::format("balls of {} names {} places", table.name(), balls),
                fmt::format("Give 1 to {}.", runtime::kMaxContacts));
  if (!table.has("radii")) return;
  tool.radius_m = table.quantities("radii", Dimension::length, kSmallestLength, kAnyLength);
  if (tool.radius_m.size() != 1 && tool.radius_m.size() != static_cast<std::size_t>(balls))
    throw Error(table.where("radii"),
                fmt::format("radii of {} names {} radii for {} balls", table.name(),
                            tool.radius_m.size(), balls),
                "Name one for each ball, or one for all.");
}

ToolSection read_played(SceneTable& table) {
  ToolSection tool;
  if (table.has("friction"))
    throw Error(table.where("friction"),
                fmt::format("friction of {} is that of [probe]", table.name()),
                "Leave it out here.");
  if (table.has("balls")) {
    tool.tilt_rad = table.quantity("tilt", Dimension::angle, tool.tilt_rad, 0, kMostTilt_rad);
    read_balls(table, tool);
  }
  return tool;
}

void finish(SceneTable& table, const std::filesystem::path& folder, double friction,
            ToolSection& tool) {
  tool.probe = read_probe(table, folder);
  tool.probe.spec.friction = friction;
}

std::vector<ToolSection> read_list(SceneTable& section, std::string_view key,
                                   const std::string& name, int points, int ToolSection::*of_which,
                                   const std::filesystem::path& folder, double friction) {
  std::vector<ToolSection> out;
  for (SceneTable& table : section.tables(key, name)) {
    ToolSection tool = read_played(table);
    tool.*of_which = static_cast<int>(table.integer("points", points, 1, 1000));
    const std::string given = table.text("name", "");
    finish(table, folder, friction, tool);
    tool.name = given.empty() ? fmt::format("{} {}", tool.probe.spec.shape, out.size() + 1) : given;
    out.push_back(std::move(tool));
  }
  return out;
}

}  // namespace

ToolSection read_tool(SceneTable& table, const std::filesystem::path& folder, double friction) {
  if (!table.has("balls"))
    throw Error(table.where_table(), "[tool] has no balls",
                "Add balls = 4, in a row along a capsule, or their places in the tool's own axes.");
  ToolSection tool = read_played(table);
  tool.name = "tool";
  tool.paths = static_cast<int>(table.integer("paths", 10, 1, 1000));
  tool.held_out = static_cast<int>(table.integer("held_out", 10, 0, 1000));
  finish(table, folder, friction, tool);
  return tool;
}

std::vector<ToolSection> read_pressed(SceneTable& experiments, const std::filesystem::path& folder,
                                      double friction) {
  constexpr int kPoints = 4;
  return read_list(experiments, "probe", "[[experiments.probe]]", kPoints, &ToolSection::paths,
                   folder, friction);
}

std::vector<ToolSection> read_stated(SceneTable& validate, const std::filesystem::path& folder,
                                     double friction) {
  constexpr int kPaths = 10;
  return read_list(validate, "tool", "[[validate.tool]]", kPaths, &ToolSection::held_out, folder,
                   friction);
}

}  // namespace palpate::tools
