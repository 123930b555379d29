#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/report/packed.hpp"

namespace palpate::tools {

/// Writes the figures for a paper that a report's contents are enough for, as SVG, into the folder,
/// which is made: curves.svg, error.svg, stiffness.svg, placement.svg. Returns their names.
std::vector<std::string> write_figures(const Json& contents, const std::filesystem::path& folder);

}  // namespace palpate::tools
