#include "tools/scene/rewrite.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <optional>

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
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
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

}  // namespace palpate::tools
