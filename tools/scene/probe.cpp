#include "tools/scene/scene.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <numbers>

#include "libfem/probes/probes.hpp"
#include "libfit/runtime/series/root.hpp"
#include "tools/scene/fields.hpp"
#include "tools/scene/nearest_name.hpp"
#include "tools/scene/toml_table.hpp"

namespace palpate::tools {
namespace {

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
  for (const fem::ProbeParameter& parameter : row.parameters) {
    if (!table.has(parameter.key)) continue;
    const bool is_length = parameter.dimension == Dimension::length;
    spec.values[std::string(parameter.key)] = {
        table.quantity(parameter.key, parameter.dimension, 0, is_length ? kSmallestLength : 0,
                       is_length ? kAnyLength : 2 * std::numbers::pi)};
  }
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

}  // namespace

ToolSection read_tool(SceneTable& table, const std::filesystem::path& folder, double friction) {
  if (!table.has("balls"))
    throw Error(table.where_table(), "[tool] has no balls",
                "Add balls = 4, in a row along a capsule, or their places in the tool's own axes.");
  ToolSection tool = read_played(table);
  tool.name = "tool";
  tool.paths = static_cast<int>(table.integer("paths", 10, 1, 1000));
  tool.held_out = static_cast<int>(table.integer("held_out", 10, 0, 1000));
  tool.probe = read_probe(table, folder);
  tool.probe.spec.friction = friction;
  return tool;
}

std::vector<ToolSection> read_tools(SceneTable& section, std::string_view key,
                                    const std::filesystem::path& folder, double friction,
                                    int points, int ToolSection::*of_which) {
  std::vector<ToolSection> out;
  const std::string& name = section.name();
  for (SceneTable& table :
       section.tables(key, fmt::format("[{}.{}]]", name.substr(0, name.size() - 1), key))) {
    ToolSection tool = read_played(table);
    tool.*of_which = static_cast<int>(table.integer("points", points, 1, 1000));
    tool.name = table.text("name", "");
    tool.probe = read_probe(table, folder);
    tool.probe.spec.friction = friction;
    if (tool.name.empty()) tool.name = fmt::format("{} {}", tool.probe.spec.shape, out.size() + 1);
    out.push_back(std::move(tool));
  }
  return out;
}

}  // namespace palpate::tools
