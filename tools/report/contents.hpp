#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "libfit/core/body.hpp"

namespace palpate::tools {

/// What a report's page shows of the folder of a run, as one JSON object (docs/formats.md). Each
/// file of a run may be missing; the page then says so. Further folders are compared with the first
/// by their figures. Throws Error where a folder has no file of a run or one is damaged.
std::string contents_of_folders(const std::vector<std::string>& folders);

/// The same of a set-up that nobody has paid for: the body and what is doubted about it.
std::string contents_of_set_up(const std::string& name, const Body& body,
                               const std::vector<std::string>& doubts);

}  // namespace palpate::tools
