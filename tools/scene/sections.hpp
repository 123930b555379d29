#pragma once

#include <filesystem>

#include "tools/scene/scene.hpp"
#include "tools/scene/toml_table.hpp"

namespace palpate::tools {

/// Sections that a manifest has, too. Throw Error at what is wrong in the file `path`.
FitSection read_fit(SceneTable table, const std::filesystem::path& path);
ExportSection read_export(SceneTable table, const std::filesystem::path& path);

}  // namespace palpate::tools
