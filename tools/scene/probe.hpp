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

/// Reads the keys that the named shape takes. Throws Error for keys of other shapes, saying whose
/// they are, and as SceneTable does. Relative file names start at `folder`.
ProbeSection read_probe(SceneTable& table, const std::filesystem::path& folder);

}  // namespace palpate::tools
