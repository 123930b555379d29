#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "libfit/core/body.hpp"

namespace palpate::tools {

/// What a report's page shows of the folder of a run, as one JSON object (docs/formats/report.md).
/// Each file of a run may be missing, not all of them. Throws Error where the folder is none of a
/// run or a file that is read is damaged.
std::string contents_of_folder(const std::string& folder);

/// The same of a scene that has not been run: its body, and sentences to be warned by.
std::string contents_of_set_up(const std::string& name, const Body& body,
                               const std::vector<std::string>& warnings);

}  // namespace palpate::tools
