#pragma once

#include <string>
#include <utility>
#include <vector>

namespace palpate::tools::testing_support {

/// An input that is refused. docs/bad-inputs.md has the answers.
struct BadInputRow {
  const char* what;     ///< is wrong
  std::string command;  ///< run in a folder that holds what a good run left, and `files`
  int status = 1;
  std::vector<std::pair<std::string, std::string>> files = {};
};

/// Wrong usage, and what is wrong with a scene, its meshes, points and paths.
std::vector<BadInputRow> bad_scenes();
/// With recordings: folders, manifests, files of instruments.
std::vector<BadInputRow> bad_recordings();
/// With files that a stage wrote, or is to write.
std::vector<BadInputRow> bad_files();

/// The good scene with one thing changed.
std::string scene_with(const std::string& from, const std::string& to);

}  // namespace palpate::tools::testing_support
