#include "libfem/mesh/read/xml_tags.hpp"

namespace palpate::mesh_read {
namespace {

constexpr std::string_view kBlanks = " \t\r\n";

// Moves past `mark`, which must follow.
void skip_past(Cursor& file, std::string_view mark) {
  const std::size_t at = file.bytes().find(mark, file.position());
  if (at == std::string_view::npos) file.fail("a tag is not closed");
  file.seek(at + mark.size());
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

}  // namespace

std::optional<XmlTag> next_tag(Cursor& file) {
  const std::string_view bytes = file.bytes();
  while (true) {
    const std::size_t open = bytes.find('<', file.position());
    if (open == std::string_view::npos) return std::nullopt;
    file.seek(open);
    if (bytes.substr(open, 4) == "<!--") {
      skip_past(file, "-->");
      continue;
    }
    skip_past(file, ">");
    std::string_view inside = bytes.substr(open + 1, file.position() - open - 2);
    if (inside.starts_with('?') || inside.starts_with('!')) continue;
    XmlTag tag;
    tag.after = file.position();
    tag.is_end = inside.starts_with('/');
    if (tag.is_end) inside.remove_prefix(1);
    tag.is_closed = inside.ends_with('/');
    if (tag.is_closed) inside.remove_suffix(1);
    tag.name = inside.substr(0, inside.find_first_of(kBlanks));
    tag.attributes = inside.substr(tag.name.size());
    file.seek(open);  // so that failures name the tag
    return tag;
  }
}

std::string_view attribute(const XmlTag& tag, std::string_view name) {
  std::string_view rest = tag.attributes;
  while (true) {
    const std::size_t equals = rest.find('=');
    if (equals == std::string_view::npos) return {};
    const std::string_view found = trimmed(rest.substr(0, equals));
    rest = trimmed(rest.substr(equals + 1));
    if (rest.empty() || (rest[0] != '"' && rest[0] != '\'')) return {};
    const std::size_t end = rest.find(rest[0], 1);
    if (end == std::string_view::npos) return {};
    if (found == name) return rest.substr(1, end - 1);
    rest.remove_prefix(end + 1);
  }
}

}  // namespace palpate::mesh_read
