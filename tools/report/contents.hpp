#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "libfit/core/body.hpp"

namespace palpate::tools {

/// What a report's page shows of a run's folder, as one JSON object (docs/formats.md). Each file
/// of a run may be missing; the page then says so. Throws Error where none is there or one is
/// damaged.
std::string contents_of_folder(const std::filesystem::path& folder);

/// The same of a set-up that nobody has paid for: the body and what is doubted about it.
std::string contents_of_set_up(const std::string& name, const Body& body,
                               const std::vector<std::string>& doubts);

}  // namespace palpate::tools
