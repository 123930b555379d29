// Words of the code are those of the field (docs/style.md): private ones and riddling beginnings of
// comments are counted per file, and named numeric constants in all. words_allowed.txt has what is
// left, and only shrinks.

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

namespace {

namespace fs = std::filesystem;

const fs::path kRoot(PALPATE_SOURCE_DIR), kAllowance = kRoot / "tests/tools/words_allowed.txt";
const char kConstants[] = "named_numeric_constants";

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

int numeric_constants(const std::string& code) {
  static const std::regex statement(
      R"re(\bconstexpr (?:static |inline )*(?:double|float|int|unsigned|long|std::u?int\w+|std::size_t)( k[A-Z][^;]*);)re");
  static const std::regex name(R"re([ ,]k[A-Z]\w* ?[={])re");
  int found = 0;
  for (std::sregex_iterator it(code.begin(), code.end(), statement), end; it != end; ++it) {
    const std::string names = (*it)[1];
    found +=
        static_cast<int>(std::distance(std::sregex_iterator(names.begin(), names.end(), name), {}));
  }
  return found;
}

std::map<std::string, int> counted() {
  static const std::set<std::string> extensions{".cpp", ".hpp", ".h", ".inc", ".ts", ".py", ".cs"};
  std::map<std::string, int> counts{{kConstants, 0}};
  for (const char* folder : {"libfem", "libfit", "tools"})
    for (auto entry = fs::recursive_directory_iterator(kRoot / folder);
         entry != fs::recursive_directory_iterator(); ++entry) {
      if (entry->path().filename() == "node_modules") entry.disable_recursion_pending();
      if (!extensions.contains(entry->path().extension().string())) continue;
      std::ifstream stream(entry->path());
      const std::string comment = entry->path().extension() == ".py" ? "#" : "//";
      const std::string code =
          without_quotations({std::istreambuf_iterator<char>(stream), {}}, comment);
      const std::string name = fs::relative(entry->path(), kRoot).generic_string();
      const int found = private_words(code) + riddling_comments(code, comment);
      if (found > 0) counts[name] = found;
      if (!name.starts_with("tools/workshop")) counts[kConstants] += numeric_constants(code);
    }
  return counts;
}

TEST(words, are_those_of_the_field) {
  std::map<std::string, int> counts = counted();
  if (std::getenv("PALPATE_WRITE_WORDS") != nullptr) {
    std::ofstream out(kAllowance);
    for (const auto& [name, count] : counts) out << name << ' ' << count << '\n';
  }
  std::map<std::string, int> allowed;
  std::ifstream stream(kAllowance);
  std::string name;
  for (int count; stream >> name >> count;) allowed[name] = count;
  for (const auto& row : allowed) counts.try_emplace(row.first, 0);
  for (const auto& [file, count] : counts) {
    EXPECT_LE(count, allowed[file]) << file << " has a new private word, beginning or constant";
    EXPECT_GE(count, allowed[file]) << file << " has fewer: PALPATE_WRITE_WORDS=1 ctest -R words";
  }
}

}  // namespace
