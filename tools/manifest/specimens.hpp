#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "libfem/calibrate/homogeneous_tests.hpp"
#include "tools/scene/key_log.hpp"

namespace palpate::tools {

/// Tests of specimens and the material that a search starts from: what a tests.toml says
/// (docs/formats/tests.md).
struct Specimens {
  fem::MaterialParameters material;
  std::vector<fem::HomogeneousTest> tests;
  std::vector<std::string> name;  ///< of each test: its kind and its file
};

/// True if the text of a TOML file has tests of specimens, as a scene has not.
bool has_specimens(const std::string& text, const std::string& file);

/// Throws Error with file:line:column of the TOML, or file:line of a table.
Specimens read_specimens(const std::string& text, const std::filesystem::path& path,
                         KeyLog* log = nullptr);

}  // namespace palpate::tools
