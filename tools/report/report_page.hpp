#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libfit/core/body.hpp"

namespace palpate::tools {

/// The folder of a run as one JSON object for the page (docs/formats/report.md).
/// Each file of a run may be missing, not all of them. Throws Error where the folder is none of a
/// run or a file that is read is damaged.
std::string contents_of_folder(const std::string& folder);

/// The same of a scene that has not been run: its body, and sentences to be warned by.
std::string contents_of_set_up(const std::string& name, const Body& body,
                               const std::vector<std::string>& warnings);

/// The page that tools/page was built to, if it is there: of an installation in
/// ../share/palpate/page.html, of a build in page/page.html, relative to the program's folder. It
/// is no part of the program, so that Palpate builds without Node.
std::optional<std::filesystem::path> find_page();

/// The first bytes of a page, by which kind_of_file knows it.
inline constexpr std::string_view kPageKind = "<!doctype html><!-- palpate -->";

/// Writes the page with its data, completely or not at all. Throws Error where there is no page.
/// contents: JSON.
void write_page(const std::filesystem::path& output, const std::string& contents);

}  // namespace palpate::tools
