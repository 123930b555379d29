// Labels of docs/method.md and of the pages beside it (docs/method-*.md): code cites each, and each
// that is cited stands there.

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "tests/support/sources.hpp"

namespace palpate {
namespace {

namespace fs = std::filesystem;
using testing_support::source_files;

// Paths of files by the label that they mention.
using Mentions = std::map<std::string, std::set<std::string>>;

// Texts of the method's pages by file name.
std::map<std::string, std::string> method_pages() {
  std::map<std::string, std::string> pages;
  for (const auto& entry : fs::directory_iterator(testing_support::kSourceRoot / "docs")) {
    const std::string name = entry.path().filename().string();
    if (name == "method.md" || (name.starts_with("method-") && name.ends_with(".md")))
      pages[name] = testing_support::text_of(entry.path());
  }
  return pages;
}

std::string method() {
  std::string text;
  for (const auto& [name, page] : method_pages()) text += page;
  return text;
}

std::vector<std::string> matches(const std::string& text, const std::regex& pattern) {
  std::vector<std::string> found;
  for (std::sregex_iterator it(text.begin(), text.end(), pattern), end; it != end; ++it)
    found.push_back((*it)[1]);
  return found;
}

// "(M5)", "(M12a)"; a list such as "(M31, M32)" mentions each.
std::vector<std::string> mentioned_labels(const std::string& text) {
  static const std::regex list(
      R"re(\(((?:[MB][0-9]+[a-z]?)(?:(?:,| and| to)\s(?:[MB][0-9]+[a-z]?))*)\))re");
  static const std::regex label(R"re(([MB][0-9]+[a-z]?))re");
  std::vector<std::string> found;
  for (const std::string& names : matches(text, list))
    for (const std::string& name : matches(names, label)) found.push_back(name);
  return found;
}

// An equation is an indented line that ends in its label.
std::vector<std::string> defined_labels() {
  static const std::regex pattern(
      R"re((?:^|\n) {4,}[^\n]*\S\s+\(([MB][0-9]+[a-z]?)\)[ ]*(?=\n|$))re");
  return matches(method(), pattern);
}

std::set<std::string> defined() {
  const std::vector<std::string> labels = defined_labels();
  return {labels.begin(), labels.end()};
}

const std::set<std::string> kCode{".cpp", ".hpp", ".h", ".inc"};

Mentions cited_in_code() {
  Mentions cited;
  for (const auto& [file, text] : source_files({"libfit", "libfem", "tools"}, kCode))
    for (const std::string& label : mentioned_labels(text)) cited[label].insert(file);
  return cited;
}

TEST(equations, a_label_stands_at_one_equation) {
  std::set<std::string> seen;
  for (const std::string& label : defined_labels())
    EXPECT_TRUE(seen.insert(label).second) << "two equations are " << label;
  EXPECT_GE(seen.size(), 20u);
}

TEST(equations, code_cites_every_label) {
  const Mentions cited = cited_in_code();
  for (const std::string& label : defined())
    EXPECT_TRUE(cited.count(label)) << "no code cites (" << label << ")";
}

TEST(equations, a_label_cited_in_code_or_docs_exists) {
  const std::set<std::string> labels = defined();
  for (const auto& files : {source_files({"libfit", "libfem", "tools", "tests"}, kCode),
                            source_files({"docs"}, {".md"})})
    for (const auto& [file, text] : files)
      for (const std::string& label : mentioned_labels(text))
        EXPECT_TRUE(labels.count(label)) << file << " cites (" << label << ")";
}

// method.md has the index of all sections; of another page the section has to be there.
TEST(equations, a_section_of_the_method_cited_in_code_exists) {
  static const std::regex heading(R"re((?:^|\n)## ([0-9]+)\. )re");
  static const std::regex citation(
      R"re((method(?:-[a-z]+)?\.md),(?:\s|//)*sections?(?:\s|//)*([0-9]+))re");
  std::map<std::string, std::set<std::string>> sections;
  for (const auto& [name, page] : method_pages())
    for (const std::string& section : matches(page, heading)) {
      EXPECT_TRUE(sections["method.md"].insert(section).second)
          << "two pages have section " << section;
      sections[name].insert(section);
    }
  EXPECT_GE(sections["method.md"].size(), 10u);
  for (const auto& [file, text] : source_files({"libfit", "libfem", "tools", "tests"}, kCode))
    for (std::sregex_iterator it(text.begin(), text.end(), citation), end; it != end; ++it)
      EXPECT_TRUE(sections[(*it)[1]].count((*it)[2]))
          << file << " cites section " << (*it)[2] << " of " << (*it)[1];
}

}  // namespace
}  // namespace palpate
