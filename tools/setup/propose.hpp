#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "libfit/core/geometry.hpp"

namespace palpate::tools {

/// What the user has decided; empty: proposed from the mesh.
struct SceneChoices {
  std::string unit{};    ///< "mm", or a length such as "110 mm"
  std::string tissue{};  ///< of data/materials.toml; empty: by the mesh's name, else liver
  bool wrap = false;     ///< whether a wrap may move the surface by more than kMostMoved
  std::string held{};    ///< side that is fixed: -x, +x, -y, +y, -z or +z
  /// What the scene calls the surface where it had to be divided.
  std::filesystem::path divided_mesh = "divided.off";
};

/// A scene to start from, and what was noticed on the way, a sentence each.
struct ProposedScene {
  std::string text, unit, tissue;
  std::vector<std::string> notes, warnings;
  /// As the scene has it [m]. is_divided: it is another than the file's, to be written beside it.
  Surface surface;
  bool is_divided = false;
};

/// The length unit that makes a mesh an organ or a specimen: its largest extent is then between
/// 3 cm and 1 m where a unit does that.
std::string likely_unit(const Vec3& extent);

/// A commented scene for a surface mesh.
/// mesh: its file, as the scene shall name it. surface: as the file holds it, in the file's unit.
/// The body rests on a flat side whose opposite can be pressed on (held where a quarter of its
/// surface lies); the window lies opposite. A window of few vertices is divided. The ball is as
/// ball_for says; it presses one radius deep, and drags go 0.8 of that, so that they slip.
/// Throws Error on a unit, tissue or side that does not exist, on a mesh beyond mending, and where
/// no window can be pressed.
ProposedScene propose_scene(const std::filesystem::path& mesh, const Surface& surface,
                            const SceneChoices& choices);

}  // namespace palpate::tools
