// Words of the code are those of the field (docs/style.md): private ones and riddling beginnings of
// comments are counted per file, named numeric constants in all. words_allowed.txt has what is
// left, and only shrinks. docs/bench/constants.csv says what half and twice of a constant change.

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/sources.hpp"

namespace palpate {
namespace {

const std::filesystem::path kAllowance =
    testing_support::kSourceRoot / "tests/tools/words_allowed.txt";

const std::set<std::string> kPrivate{
    "way",  "ways",  "told", "tell", "tells",   "telling", "borne", "bear",   "bears", "bearing",
    "feel", "feels", "felt", "give", "feeling", "gives",   "given", "giving", "gave"};

// Code with comments, without literals and what comments quote.
std::string without_quotations(const std::string& text, const std::string& comment) {
  std::string out;
  bool is_comment = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    is_comment = c != '\n' && (is_comment || text.compare(i, comment.size(), comment) == 0);
    const bool is_name = i > 0 && std::isalnum(static_cast<unsigned char>(text[i - 1]));
    out += c;
    if (c == '"' && i > 0 && text[i - 1] == 'R') {
      const std::size_t open = text.find('(', i);
      i = text.find(")" + text.substr(i + 1, open - i - 1) + "\"", open);
    } else if (c == '"' || (!is_comment && (c == '`' || (c == '\'' && !is_name)))) {
      while (++i < text.size() && text[i] != c && (c == '`' || text[i] != '\n'))
        if (text[i] == '\\') ++i;
      if (i < text.size() && text[i] == '\n') --i;
    }
  }
  return out;
}

// Names are taken apart: way_in and kWayIn have "way".
int private_words(const std::string& code) {
  static const std::regex part("[A-Z]?[a-z]+|[A-Z]+");
  int found = 0;
  for (std::sregex_iterator it(code.begin(), code.end(), part), end; it != end; ++it) {
    std::string word = it->str();
    std::ranges::transform(word, word.begin(), [](unsigned char c) { return std::tolower(c); });
    found += kPrivate.contains(word) ? 1 : 0;
  }
  return found;
}

// A comment goes on over the lines below it.
int riddling_comments(const std::string& code, const std::string& comment) {
  static const std::regex beginning("^[/!*#]*<? *(What|Of|Where|Whether|How)\\b");
  std::istringstream lines(code);
  int found = 0;
  bool goes_on = false;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t at = std::min(line.find(comment), line.find("/*"));
    const bool is_whole = at != std::string::npos && line.find_first_not_of(' ') == at;
    if (at != std::string::npos && !(is_whole && goes_on))
      found += std::regex_search(line.substr(at), beginning) ? 1 : 0;
    goes_on = is_whole;
  }
  return found;
}

struct NumericConstant {
  std::string name, value;
  std::string comment;  ///< beside its statement and right above it
};

// Those with a literal value: one that is made of others is no number of its own.
std::vector<NumericConstant> numeric_constants(const std::string& text) {
  static const std::regex statement(
      R"re(((?:\n *//[^\n]*)*)\n[^\n/]*\bconstexpr (?:static |inline )*(?:double|float|int|unsigned|long|std::u?int\w+|std::size_t|Eigen::Index)( k[A-Z][^;]*);([^\n]*))re");
  static const std::regex name(R"re([ ,](k[A-Z]\w*) = ([-0-9eE.+*/()xu' ]+)(?=,|$))re");
  std::vector<NumericConstant> found;
  for (std::sregex_iterator it(text.begin(), text.end(), statement), end; it != end; ++it) {
    const std::string names = (*it)[2];
    for (std::sregex_iterator part(names.begin(), names.end(), name); part != end; ++part)
      found.push_back({(*part)[1], (*part)[2], (*it)[1].str() + (*it)[3].str()});
  }
  return found;
}

// Numbers, equations and sources in a comment say how its constant was chosen.
bool has_evidence(const std::string& comment) {
  static const std::regex evidence(
      R"re([Mm]easured|[Hh]alf|[0-9]+ to [0-9]|\((M|S|B)[0-9]+|[a-z] [12][0-9]{3}\b|[0-9.]+ (%|s|ms|mm|um|times|of)\b)re");
  return std::regex_search(comment, evidence);
}

// "file,name,value" of each row.
std::set<std::string> measured_constants() {
  std::istringstream table(
      testing_support::text_of(testing_support::kSourceRoot / "docs/bench/constants.csv"));
  std::set<std::string> rows;
  std::string line;
  std::getline(table, line);
  for (std::string file, name, value; std::getline(table, line);) {
    std::istringstream fields(line);
    for (std::string* field : {&file, &name, &value}) std::getline(fields, *field, ',');
    rows.insert(file + ',' + name + ',' + value);
  }
  return rows;
}

TEST(words, are_those_of_the_field) {
  std::map<std::string, int> counts;
  std::set<std::string> measured = measured_constants();
  EXPECT_FALSE(measured.empty());
  for (const auto& [name, text] : testing_support::source_files(
           {"libfem", "libfit", "tools"}, {".cpp", ".hpp", ".h", ".inc", ".ts", ".py", ".cs"})) {
    const std::string comment = name.ends_with(".py") ? "#" : "//";
    const std::string code = without_quotations(text, comment);
    const int found = private_words(code) + riddling_comments(code, comment);
    if (found > 0) counts[name] = found;
    if (name.starts_with("tools/workshop")) continue;
    for (const NumericConstant& constant : numeric_constants(text)) {
      ++counts["numeric_constants"];
      const bool is_measured =
          measured.erase(name + ',' + constant.name + ',' + constant.value) > 0;
      counts["numeric_constants_without_evidence"] +=
          is_measured || has_evidence(constant.comment) ? 0 : 1;
    }
  }
  for (const std::string& row : measured) ADD_FAILURE() << row << " is no constant of the code";
  if (std::getenv("PALPATE_WRITE_WORDS") != nullptr) {
    std::ofstream out(kAllowance);
    for (const auto& [name, count] : counts) out << name << ' ' << count << '\n';
  }
  std::map<std::string, int> allowed;
  std::ifstream stream(kAllowance);
  for (std::string name; stream >> name;) stream >> allowed[name];
  for (const auto& row : allowed) counts.try_emplace(row.first, 0);
  for (const auto& [file, count] : counts) {
    EXPECT_LE(count, allowed[file]) << file << " has a new private word, beginning or constant";
    EXPECT_GE(count, allowed[file]) << file << " has fewer: PALPATE_WRITE_WORDS=1 ctest -R words";
  }
}

}  // namespace
}  // namespace palpate
