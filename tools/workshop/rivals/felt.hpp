#pragma once

#include <filesystem>
#include <vector>

#include "tools/workshop/rivals/rival.hpp"

namespace palpate::tools {

/// Writes what a report's page needs to answer as rivals do (`rivals.json` of the run's folder:
/// docs/formats/run.md), and beside it forces of each along a path, by which a page can be tested.
void write_felt(const std::filesystem::path& run, const std::vector<Rival>& rivals,
                const RivalBody& body);

}  // namespace palpate::tools
