#include "libfit/recordings/formats/importers.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <locale>

namespace palpate::importers {
namespace {

bool is_control(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return (byte < 32 && c != '\n' && c != '\r' && c != '\t' && c != '\f' && c != '\v') ||
         byte == 127;
}

const auto& utf16() {
  return std::use_facet<std::codecvt<char16_t, char8_t, std::mbstate_t>>(std::locale::classic());
}

// Index of the first byte that is not UTF-8 (RFC 3629); the size when all is.
std::size_t first_invalid(std::string_view text) {
  // The facet of GCC 12 takes surrogates, which begin with ED and A0 to BF, for characters.
  std::size_t end = text.find('\xED');
  while (end < text.size() &&
         (end + 1 == text.size() || static_cast<unsigned char>(text[end + 1]) < 0xA0))
    end = text.find('\xED', end + 1);
  std::mbstate_t state{};
  const auto* begin = reinterpret_cast<const char8_t*>(text.data());
  return utf16().length(state, begin, begin + std::min(end, text.size()), text.size());
}

// As UTF-8, up to the first unit that is none; how many there are before it.
std::pair<std::string, std::size_t> as_utf8(std::u16string_view units) {
  std::string text(3 * units.size(), '\0');
  std::mbstate_t state{};
  const char16_t* read = nullptr;
  auto* const begin = reinterpret_cast<char8_t*>(text.data());
  char8_t* written = nullptr;
  utf16().out(state, units.data(), units.data() + units.size(), read, begin, begin + text.size(),
              written);
  text.resize(written - begin);
  return {text, read - units.data()};
}

std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
    lines.push_back(text.substr(0, end));
    const bool is_pair = end + 1 < text.size() && text[end] == '\r' && text[end + 1] == '\n';
    text.remove_prefix(std::min(end + (is_pair ? 2 : 1), text.size()));
  }
  return lines;
}

}  // namespace

bool is_utf16(std::string_view bytes) {
  return bytes.starts_with("\xff\xfe") || bytes.starts_with("\xfe\xff");
}

std::string utf8_of(const std::filesystem::path& path, std::string_view bytes) {
  const bool is_little = bytes[0] == '\xff';
  std::u16string units;
  for (std::size_t i = 2; i + 1 < bytes.size(); i += 2) {
    const auto first = static_cast<unsigned char>(bytes[i]),
               second = static_cast<unsigned char>(bytes[i + 1]);
    units += static_cast<char16_t>(is_little ? second << 8 | first : first << 8 | second);
  }
  auto [text, converted] = as_utf8(units);
  if (converted < units.size() || bytes.size() % 2 == 1)
    throw Error(fmt::format("{}:{}", path.string(), std::ranges::count(text, '\n') + 1),
                "is UTF-16 text that is damaged or cut short",
                "Save it again, or as UTF-8: iconv -f UTF-16 -t UTF-8 does.");
  return text;
}

TextFile::TextFile(const std::filesystem::path& path, std::string_view bytes,
                   std::string_view encoding)
    : path_(path) {
  if (bytes.starts_with("\xEF\xBB\xBF")) bytes.remove_prefix(3);  // byte order mark
  if (unquoted(bytes).empty()) throw Error(path.string() + ":1", "is empty", kNoRowRemedy);
  const auto line_of = [&](std::size_t at) {
    return fmt::format("{}:{}", path.string(), lines_of(bytes.substr(0, at + 1)).size());
  };
  const std::size_t zero = bytes.find('\0');
  const auto controls = static_cast<double>(std::count_if(bytes.begin(), bytes.end(), is_control));
  if (zero != std::string_view::npos || controls > 0.01 * static_cast<double>(bytes.size()))
    throw Error(line_of(zero == std::string_view::npos ? 0 : zero), "is binary data, not text",
                "Export the recording as text, or name its `format` in the manifest.");
  if (encoding == "latin-1") {
    std::u16string units;  // its characters are the first of Unicode's
    for (const char c : bytes) units += static_cast<unsigned char>(c);
    converted_ = as_utf8(units).first;
    bytes = converted_;
  } else if (const std::size_t bad = first_invalid(bytes); bad < bytes.size()) {
    throw Error(line_of(bad), "is not UTF-8 text",
                "Say encoding = \"latin-1\" in the manifest, or save the file as UTF-8.");
  }
  line_ = lines_of(bytes);
}

Error TextFile::error(std::size_t index, const std::string& what, const std::string& remedy) const {
  return Error(fmt::format("{}:{}", path_.string(), index + 1), what, remedy);
}

std::string_view unquoted(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\n\f\v";
  const auto strip = [&] {
    const std::size_t first = text.find_first_not_of(kBlank);
    text = first == std::string_view::npos
               ? std::string_view{}
               : text.substr(first, text.find_last_not_of(kBlank) - first + 1);
  };
  strip();
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"') {
    text = text.substr(1, text.size() - 2);
    strip();
  }
  return text;
}

std::vector<std::string_view> split(std::string_view line, char separator) {
  std::vector<std::string_view> fields;
  if (separator == ' ') {
    while (true) {
      const std::size_t first = line.find_first_not_of(" \t");
      if (first == std::string_view::npos) return fields;
      line.remove_prefix(first);
      const std::size_t end = std::min(line.find_first_of(" \t"), line.size());
      fields.push_back(unquoted(line.substr(0, end)));
      line.remove_prefix(end);
    }
  }
  bool is_quoted = false;
  std::size_t begin = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') is_quoted = !is_quoted;
    if (line[i] != separator || is_quoted) continue;
    fields.push_back(unquoted(line.substr(begin, i - begin)));
    begin = i + 1;
  }
  fields.push_back(unquoted(line.substr(begin)));
  return fields;
}

bool is_comment(std::string_view line, std::string_view mark) {
  line = unquoted(line);
  return line.empty() || (!mark.empty() && line.starts_with(mark));
}

bool has_word(std::string_view list, std::string_view word) {
  const auto words = split(list, ' ');
  return std::ranges::find(words, word) != words.end();
}

char guess_separator(std::string_view line) {
  for (const char c : {'\t', ';', ','})
    if (line.find(c) != std::string_view::npos) return c;
  return ' ';
}

std::optional<double> parse_number(std::string_view text, char decimal) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  char buffer[64];
  if (decimal != '.' || text.find(',') != std::string_view::npos) {
    if (text.size() > sizeof buffer ||
        text.find(decimal == ',' ? '.' : ',') != std::string_view::npos)
      return std::nullopt;
    std::transform(text.begin(), text.end(), buffer,
                   [&](char c) { return c == decimal ? '.' : c; });
    text = {buffer, text.size()};
  }
  double value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

std::optional<std::string> without_groups(std::string_view text, char group) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  std::size_t i = !text.empty() && (text[0] == '-' || text[0] == '+') ? 1 : 0;
  const std::size_t first = i;
  while (i < text.size() && is_digit(text[i])) ++i;
  if (i == first || i > first + 3 || i == text.size() || text[i] != group || text[first] == '0')
    return std::nullopt;
  std::string out(text.substr(0, i));
  while (i < text.size() && text[i] == group) {
    const std::string_view digits = text.substr(i + 1, 3);
    if (digits.size() < 3 || !std::ranges::all_of(digits, is_digit)) return std::nullopt;
    out += digits;
    i += 4;
  }
  if (i < text.size() && (is_digit(text[i]) || text.find(group, i) != std::string_view::npos))
    return std::nullopt;
  return out += text.substr(i);
}

bool is_blank_field(std::string_view text) {
  return text.empty() || text == "nan" || text == "NaN" || text == "NAN";
}

std::pair<std::string, std::string> split_unit(std::string_view name) {
  std::string text;
  for (std::size_t i = 0; i < name.size(); ++i) {  // U+00B5 and U+03BC
    const std::string_view pair = name.substr(i, 2);
    const bool is_micro = pair == "\xC2\xB5" || pair == "\xCE\xBC";
    text += is_micro ? 'u' : name[i];
    i += is_micro;
  }
  for (const auto& [open, close] : {std::pair{'(', ')'}, std::pair{'[', ']'}}) {
    const std::size_t from = text.rfind(open);
    if (from == std::string::npos || text.empty() || text.back() != close) continue;
    return {std::string(unquoted(text.substr(0, from))),
            std::string(unquoted(text.substr(from + 1, text.size() - from - 2)))};
  }
  return {text, {}};
}

namespace {

std::optional<double> tick_of(std::string_view text, std::optional<std::int64_t>& first) {
  std::int64_t ticks = 0, since = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), ticks);
  if (failure != std::errc() || end != text.data() + text.size() ||
      (!first && std::abs(static_cast<double>(ticks)) < 0x1p53))  // a double resolves it
    return std::nullopt;
  if (!first) first = ticks;
  if (__builtin_sub_overflow(ticks, *first, &since)) return std::nullopt;
  return static_cast<double>(since);
}

// The number in a field of the column asked for as number c.
std::optional<double> number_in(std::string_view text, std::size_t c, const TableLayout& layout) {
  if (layout.first_tick && c < layout.is_clock.size() && layout.is_clock[c])
    if (const auto tick = tick_of(text, *layout.first_tick)) return tick;
  if (const auto number = parse_number(text, layout.decimal)) return number;
  const char group = layout.decimal == '.' ? ',' : '.';
  const bool is_sure = layout.has_groups || text.find(layout.decimal) != std::string_view::npos;
  const auto joined = is_sure ? without_groups(text, group) : std::nullopt;
  return joined ? parse_number(*joined, layout.decimal) : std::nullopt;
}

}  // namespace

NumberTable read_numbers(const TextFile& file, const TableLayout& layout) {
  NumberTable table;
  table.column.resize(layout.field.size());
  std::vector<double> row(layout.field.size());
  for (std::size_t i = layout.first; i < file.lines(); ++i) {
    if (is_comment(file.line(i), layout.comment)) continue;
    const auto fields = split(file.line(i), layout.separator);
    const auto is_blank = [&](std::size_t f) { return f >= fields.size() || fields[f].empty(); };
    if (std::all_of(layout.field.begin(), layout.field.end(), is_blank)) continue;
    bool is_row = !layout.shares_clock;
    for (std::size_t c = 0; c < row.size() && !is_row; ++c)
      is_row = !layout.is_clock[c] && !is_blank(layout.field[c]) &&
               !is_blank_field(fields[layout.field[c]]);
    if (!is_row) continue;
    std::string what;
    for (std::size_t c = 0; c < row.size() && what.empty(); ++c) {
      if (is_blank(layout.field[c])) {
        what = "column `" + layout.name[c] + "` has no value here";
      } else if (const auto number = number_in(fields[layout.field[c]], c, layout);
                 number && std::abs(*number) <= kLargestNumber) {
        row[c] = *number;
      } else {
        const std::string shown(fields[layout.field[c]].substr(0, 24));
        what = "column `" + layout.name[c] + "`: `" + shown + "` is " +
               (number ? "out of range" : "not a number");
      }
    }
    if (!what.empty()) throw file.error(i, what, kBadRowRemedy);
    for (std::size_t c = 0; c < row.size(); ++c) table.column[c].push_back(row[c]);
    table.line.push_back(i + 1);
  }
  if (table.line.empty()) throw Error(file.path().string(), "has no row of numbers", kNoRowRemedy);
  return table;
}

}  // namespace palpate::importers
