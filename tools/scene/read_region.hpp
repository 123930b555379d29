#pragma once

#include <filesystem>
#include <string>

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

}  // namespace palpate::tools
