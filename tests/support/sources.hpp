#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

// The files of the repository, for tests of what is written in them.
namespace palpate::testing_support {

inline const std::filesystem::path kSourceRoot(PALPATE_SOURCE_DIR);

inline std::string text_of(const std::filesystem::path& path) {
  std::ifstream stream(path);
  return {std::istreambuf_iterator<char>(stream), {}};
}

struct SourceFile {
  std::string name;  ///< from the root, with slashes
  std::string text;
};

/// Files of some folders by their extensions; npm's packages are nobody's source.
inline std::vector<SourceFile> source_files(const std::vector<std::string>& folders,
                                            const std::set<std::string>& extensions) {
  namespace fs = std::filesystem;
  std::vector<SourceFile> files;
  for (const std::string& folder : folders)
    for (auto entry = fs::recursive_directory_iterator(kSourceRoot / folder);
         entry != fs::recursive_directory_iterator(); ++entry) {
      if (entry->path().filename() == "node_modules") entry.disable_recursion_pending();
      if (extensions.contains(entry->path().extension().string()))
        files.push_back(
            {fs::relative(entry->path(), kSourceRoot).generic_string(), text_of(entry->path())});
    }
  return files;
}

}  // namespace palpate::testing_support
