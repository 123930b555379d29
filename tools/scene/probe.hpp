#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "libfem/probes/probes.hpp"

namespace palpate::tools {

class SceneTable;

/// [probe] of a scene: numbers and directions as libfem wants them, the mesh still a file. The
/// shape "point" is for measured data alone: it has no keys, and simulation refuses it.
struct ProbeSection {
  fem::ProbeSpec spec = fem::sphere_spec(fem::kDefaultBallRadius_m, 0.3);  ///< without its mesh
  std::optional<std::filesystem::path> mesh;                               ///< absolute
  double mesh_unit_m = 0;
};

/// Reads the keys that the named shape takes. Throws Error for keys of other shapes, saying whose
/// they are, and as SceneTable does. Relative file names start at `folder`.
ProbeSection read_probe(SceneTable& table, const std::filesystem::path& folder);

/// The radius an asset records: that of a ball, 0 for other shapes, which the engine plays as a
/// point.
double recorded_radius_m(const ProbeSection& section);

/// One line that differs when the probe differs, the bytes of its mesh apart.
std::string canonical(const ProbeSection& section);

}  // namespace palpate::tools
