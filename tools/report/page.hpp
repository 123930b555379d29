#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace palpate::tools {

/// The page that tools/page was built to, if it is there: of an installation in
/// ../share/palpate/page.html, of a build in page/page.html, seen from the program's folder. It is
/// no part of the program, so that Palpate builds without Node.
std::optional<std::filesystem::path> find_page();

/// How a page begins: what tells one from other files (kind_of_file).
inline constexpr std::string_view kPageKind = "<!doctype html><!-- palpate -->";

/// Writes the page with its data, whole or not at all. Throws Error where there is no page.
/// contents: JSON (contents.hpp).
void write_page(const std::filesystem::path& output, const std::string& contents);

}  // namespace palpate::tools
