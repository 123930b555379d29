// Every page that a document links to, or that code names, is there with its heading.

#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "tests/support/sources.hpp"

namespace palpate {
namespace {

namespace fs = std::filesystem;

using testing_support::source_files;
using testing_support::SourceFile;
using testing_support::text_of;

const fs::path& kRoot = testing_support::kSourceRoot;

// As the hosts of repositories make one of a heading: lower case, blanks to hyphens, only letters,
// digits, hyphens and underscores.
std::string anchor_of(const std::string& heading) {
  std::string anchor;
  for (const char c : heading) {
    const auto u = static_cast<unsigned char>(c);
    if (std::isalnum(u) || c == '-' || c == '_' || u >= 0x80)
      anchor += static_cast<char>(std::tolower(u));
    else if (c == ' ')
      anchor += '-';
  }
  return anchor;
}

std::set<std::string> anchors_of(const fs::path& page) {
  static const std::regex heading("(?:^|\n)#+ ([^\n]+)");
  const std::string text = text_of(page);
  std::set<std::string> anchors;
  for (std::sregex_iterator it(text.begin(), text.end(), heading), end; it != end; ++it)
    anchors.insert(anchor_of((*it)[1]));
  return anchors;
}

TEST(links, of_documents_lead_to_files_and_headings_that_are_there) {
  static const std::regex link(R"re(\]\(([^)\s]+)\))re");
  std::vector<SourceFile> pages = source_files({"docs"}, {".md"});
  pages.push_back({"README.md", text_of(kRoot / "README.md")});
  int checked = 0;
  for (const auto& [name, text] : pages) {
    const fs::path page = kRoot / name;
    for (std::sregex_iterator it(text.begin(), text.end(), link), end; it != end; ++it, ++checked) {
      const std::string target = (*it)[1];
      if (target.find("://") != std::string::npos || target.starts_with("mailto:")) continue;
      const std::size_t hash = target.find('#');
      const fs::path file = hash == 0 ? page : page.parent_path() / target.substr(0, hash);
      EXPECT_TRUE(fs::exists(file)) << page << " links to " << target;
      if (hash == std::string::npos || file.extension() != ".md" || !fs::exists(file)) continue;
      EXPECT_TRUE(anchors_of(file).contains(target.substr(hash + 1)))
          << page << " links to " << target << ", and there is no such heading";
    }
  }
  EXPECT_GT(checked, 200);
}

TEST(links, pages_that_code_names_are_there) {
  static const std::regex page(R"re(docs/[a-zA-Z0-9_/-]+\.md)re");
  int checked = 0;
  for (const auto& [file, text] :
       source_files({"libfit", "libfem", "tools", "tests", "data"},
                    {".cpp", ".hpp", ".h", ".ts", ".py", ".toml", ".cmake", ".txt", ".sh"}))
    for (std::sregex_iterator it(text.begin(), text.end(), page), end; it != end; ++it, ++checked)
      EXPECT_TRUE(fs::exists(kRoot / it->str())) << file << " names " << it->str();
  EXPECT_GT(checked, 50);
}

}  // namespace
}  // namespace palpate
