#include "tools/scene/canonical.hpp"

#include <fmt/core.h>

#include <fmt/format.h>
#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "libfit/core/error.hpp"
#include "tools/scene/toml_table.hpp"

namespace palpate::tools {
namespace {

constexpr const char* kRemedy = "Mend the TOML at this place.";

// The byte of a place that toml++ counts in lines and code points, from 1.
std::size_t byte_at(const std::string& text, const toml::source_position& place) {
  std::size_t at = 0;
  for (toml::source_index line = 1; line < place.line; ++line) at = text.find('\n', at) + 1;
  for (toml::source_index column = 1; column < place.column && at < text.size(); ++column) {
    ++at;
    while (at < text.size() && (static_cast<unsigned char>(text[at]) & 0xC0) == 0x80) ++at;
  }
  return at;
}

}  // namespace

std::string rewritten(std::string text, const std::string& file,
                      const std::vector<NewValue>& values) {
  for (const NewValue& value : values) {  // places move with each
    const toml::table parsed = parse_toml(text, file, kRemedy);
    const toml::table* section = parsed[value.section].as_table();
    if (!section || section->empty()) continue;
    if (const toml::node* node = section->get(value.key)) {
      const std::size_t begin = byte_at(text, node->source().begin);
      text.replace(begin, byte_at(text, node->source().end) - begin, value.value);
      continue;
    }
    std::size_t last = 0;
    for (const auto& [key, node] : *section)
      last = std::max(last, byte_at(text, node.source().end));
    if (section->is_inline())
      text.insert(last, fmt::format(", {} = {}", value.key, value.value));
    else
      text.insert(std::min(text.find('\n', last), text.size()),
                  fmt::format("\n{} = {}", value.key, value.value));
  }
  return text;
}

std::string quoted(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::vector<NewValue> absolute_files(const std::string& text, const std::string& file) {
  const toml::table parsed = parse_toml(text, file, kRemedy);
  const auto folder = std::filesystem::absolute(file).parent_path();
  std::vector<NewValue> out;
  for (const auto& [section, key] : kSceneFiles) {
    const auto name = parsed[section][key].value<std::string>();
    if (!name || name->starts_with('$') ||
        (std::string_view(key) == "test_points" && !name->ends_with(".csv")))
      continue;
    out.push_back({section, key, std::filesystem::weakly_canonical(folder / *name).string()});
  }
  return out;
}

namespace {

// Offset of a character that is not ASCII where TOML has none: outside strings and comments, or
// behind a backslash and blanks, of a text that is TOML. npos where there is none; a byte order
// mark at the beginning is none.
std::size_t misplaced_character(std::string_view text) {
  constexpr std::string_view kQuotes[] = {"\"\"\"", "'''", "\"", "'"};
  std::string_view open;  // of the string we are in
  bool is_comment = false, is_escaped = false;
  for (std::size_t i = text.starts_with("\xEF\xBB\xBF") ? 3 : 0; i < text.size(); ++i) {
    const char c = text[i];
    const bool is_ascii = static_cast<unsigned char>(c) < 0x80, is_blank = c == ' ' || c == '\t';
    if (!is_ascii && (is_escaped || (open.empty() && !is_comment))) return i;
    if (is_escaped) {
      is_escaped = open.size() == 3 && (is_blank || c == '\n' || c == '\r');
      if (c != '\n') continue;
    }
    if (c == '\n') {
      is_comment = false;
      if (open.size() == 1) open = {};  // an error, which toml++ tells
    } else if (!open.empty()) {
      if (text.substr(i).starts_with(open)) {
        i += open.size() - 1;
        for (int more = 0; more < 2 && open.size() == 3 && text.substr(i + 1).starts_with(open[0]);
             ++more)
          ++i;  // quotes that the string ends with
        open = {};
      } else {
        is_escaped = c == '\\' && open[0] == '"';
      }
    } else if (!is_comment) {
      is_comment = c == '#';
      for (const std::string_view quotes : kQuotes)
        if (open.empty() && text.substr(i).starts_with(quotes)) {
          open = quotes;
          i += quotes.size() - 1;
        }
    }
  }
  return std::string_view::npos;
}

// The text with a question mark for each character that is not ASCII.
std::string ascii_of(std::string_view text) {
  const std::string_view mark = "\xEF\xBB\xBF";
  std::string out(text.starts_with(mark) ? mark : "");
  for (const char c : text.substr(out.size())) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80) out += c;
    if (byte >= 0xC0) out += '?';
  }
  return out;
}

}  // namespace

// toml++ 3 is undefined where a character that is not ASCII is out of place (its tables of blanks
// have a hole). So it reads the text without such characters first; where that is TOML, we know
// where strings are.
toml::table parse_toml(std::string_view text, const std::string& file, const std::string& remedy) {
  if (const std::size_t at = misplaced_character(text); at != std::string_view::npos) {
    const std::string_view before = text.substr(0, at);
    const auto line = 1 + std::count(before.begin(), before.end(), '\n');
    const std::size_t column = at - (before.rfind('\n') + 1) + 1;
    throw Error(fmt::format("{}:{}:{}", file, line, column),
                "a character that is not ASCII stands outside quotes",
                "Put it in quotes, or remove it: a blank may be one that does not break.");
  }
  try {
    static_cast<void>(toml::parse(ascii_of(text), file));
    return toml::parse(text, file);
  } catch (const toml::parse_error& e) {
    throw Error(fmt::format("{}:{}:{}", file, e.source().begin.line, e.source().begin.column),
                std::string(e.description()), remedy);
  }
}

}  // namespace palpate::tools
