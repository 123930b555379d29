#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "libfem/probes/probes.hpp"
#include "libfit/core/probe.hpp"

namespace palpate::tools {

class SceneTable;

/// [probe] of a scene: numbers and directions as libfem wants them, the mesh still a file. The
/// shape "point" is for measured data alone: it has no keys, and simulation refuses it.
struct ProbeSection {
  ProbeSpec spec = sphere_spec(kDefaultBallRadius_m, kDefaultFriction);
  std::optional<std::filesystem::path> mesh;  ///< absolute; none once it is read into spec.mesh
  double mesh_unit_m = 0;
  std::optional<fem::Probe> rigid;  ///< the shape that `spec` describes (resolve_probes)
};

/// A rigid tool beside [probe]: [tool], [[experiments.probe]] or [[validate.tool]] of a scene. The
/// engine plays it as balls (docs/method-tools.md, section 29; at most one of row and balls_m), or
/// without any by the round end that it has along its press (section 30).
struct ToolSection {
  std::string name;
  ProbeSection probe;            ///< its shape; friction is that of [probe]
  int row = 0;                   ///< balls evenly along a capsule, from end to end
  Points balls_m;                ///< centres in the tool's own axes
  std::vector<double> radius_m;  ///< of each ball, or of all; none: the probe's, or the capsule's
  double tilt_rad = 0.6;         ///< up to which it leans in experiments, played as balls
  int paths = 0;                 ///< experiments that identify, of [tool] and [[experiments.probe]]
  int held_out = 0;              ///< that the statement compares, of [tool] and [[validate.tool]]

  bool has_balls() const { return row > 0 || balls_m.rows() > 0; }
};

/// Reads [tool]. Throws as read_probe.
ToolSection read_tool(SceneTable& table, const std::filesystem::path& folder, double friction);

/// Reads [[experiments.probe]] or [[validate.tool]]: tools that are pressed at some points, or that
/// the statement compares. points: their number where a table says nothing, and what it is of.
/// Throws as read_probe.
std::vector<ToolSection> read_tools(SceneTable& section, std::string_view key,
                                    const std::filesystem::path& folder, double friction,
                                    int points, int ToolSection::*of_which);

/// Reads the keys that the named shape takes. Throws Error for keys of other shapes, saying whose
/// they are, and as SceneTable does. Relative file names start at `folder`.
ProbeSection read_probe(SceneTable& table, const std::filesystem::path& folder);

}  // namespace palpate::tools
