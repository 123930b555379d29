#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "libfit/core/probe.hpp"

namespace palpate::tools {

class SceneTable;

/// [probe] of a scene: numbers and directions as libfem wants them, the mesh still a file. The
/// shape "point" is for measured data alone: it has no keys, and simulation refuses it.
struct ProbeSection {
  ProbeSpec spec = sphere_spec(kDefaultBallRadius_m, kDefaultFriction);
  std::optional<std::filesystem::path> mesh;  ///< absolute; none once it is read into spec.mesh
  double mesh_unit_m = 0;
};

/// [tool] of a scene: a rigid tool that the engine plays as balls of the probe's radius
/// (docs/method.md, section 29). Exactly one of row and balls_m.
struct ToolSection {
  ProbeSection probe;     ///< its shape; friction is that of [probe]
  int row = 0;            ///< balls evenly along a capsule, from end to end
  Points balls_m;         ///< centres in the tool's own axes
  double tilt_rad = 0.6;  ///< up to which it leans in experiments
  int paths = 10;         ///< simulated to find how its balls feel each other
  int held_out = 10;      ///< that the statement compares
};

/// Reads [tool]. Throws as read_probe.
ToolSection read_tool(SceneTable& table, const std::filesystem::path& folder, double friction);

/// Reads the keys that the named shape takes. Throws Error for keys of other shapes, saying whose
/// they are, and as SceneTable does. Relative file names start at `folder`.
ProbeSection read_probe(SceneTable& table, const std::filesystem::path& folder);

}  // namespace palpate::tools
