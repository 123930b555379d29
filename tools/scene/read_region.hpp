#pragma once

#include <filesystem>
#include <string>

#include "libfem/materials/materials.hpp"
#include "tools/scene/region.hpp"
#include "tools/scene/toml_table.hpp"

namespace palpate::tools {

/// The file that a scene names, absolute: beside the scene, or below the folder that PALPATE_DATA
/// names. Throws Error where the scene needs that folder and it is not set.
std::filesystem::path file_beside(const std::filesystem::path& scene, const std::string& name);

/// The one region that the keys of a table name; its other keys are left. Throws Error with
/// file:line:column where they name none or several, or one of its values is wrong.
Region take_region(SceneTable& table, const std::filesystem::path& scene);

/// The same of a table that holds nothing else.
Region read_region(SceneTable table, const std::filesystem::path& scene);

/// One of the regions above, what faces a side, or both; nothing else is in the table.
SurfaceRegion read_surface_region(SceneTable table, const std::filesystem::path& scene);

/// The material of a table: `law`, and the keys of that law's parameter rows. Returns a value for
/// every row, SI; NaN for an optional one left out. may_relax: the keys
/// `relaxation` and `softening` are among them.
/// Throws Error with file:line:column for an unknown law or key (naming the nearest), a key missing
/// or of the wrong kind or unit, two keys that exclude each other, and values that the law refuses.
fem::MaterialParameters read_material(SceneTable table, bool may_relax = false);

}  // namespace palpate::tools
