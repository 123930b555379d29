#include "libfit/recordings/formats/text_file.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>

namespace palpate::importers {
namespace {

constexpr double kLargestNumber = 1e15;  // beyond any rig; keeps sums of squares finite
constexpr double kControlShare = 0.01;   // more control characters than this are no text
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

bool is_control(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return (byte < 32 && c != '\n' && c != '\r' && c != '\t' && c != '\f' && c != '\v') ||
         byte == 127;
}

// Length of the UTF-8 sequence that begins here; 0 when it is none (RFC 3629, overlong refused).
std::size_t sequence_length(std::string_view text) {
  const auto at = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned lead = at(0);
  if (lead < 0x80) return 1;
  const std::size_t length = lead >= 0xC2 && lead < 0xE0   ? 2
                             : lead >= 0xE0 && lead < 0xF0 ? 3
                             : lead >= 0xF0 && lead < 0xF5 ? 4
                                                           : 0;
  if (length == 0 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((at(i) & 0xC0) != 0x80) return 0;
  if ((lead == 0xE0 && at(1) < 0xA0) || (lead == 0xED && at(1) > 0x9F) ||
      (lead == 0xF0 && at(1) < 0x90) || (lead == 0xF4 && at(1) > 0x8F))
    return 0;
  return length;
}

// Index of the first byte that is not UTF-8; the size when all is.
std::size_t first_invalid(std::string_view text) {
  std::size_t i = 0;
  while (i < text.size()) {
    if (static_cast<unsigned char>(text[i]) < 0x80) {
      ++i;
      continue;
    }
    const std::size_t length = sequence_length(text.substr(i));
    if (length == 0) return i;
    i += length;
  }
  return i;
}

std::string from_latin1(std::string_view bytes) {
  std::string text;
  text.reserve(bytes.size() + bytes.size() / 16);
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80) {
      text += c;
    } else {
      text += static_cast<char>(0xC0 | (byte >> 6));
      text += static_cast<char>(0x80 | (byte & 0x3F));
    }
  }
  return text;
}

void append_utf8(std::uint32_t code, std::string& text) {
  const auto put = [&](std::uint32_t byte) { text += static_cast<char>(byte); };
  if (code < 0x80) return put(code);
  if (code < 0x800) {
    put(0xC0 | (code >> 6));
  } else {
    if (code < 0x10000) {
      put(0xE0 | (code >> 12));
    } else {
      put(0xF0 | (code >> 18));
      put(0x80 | ((code >> 12) & 0x3F));
    }
    put(0x80 | ((code >> 6) & 0x3F));
  }
  put(0x80 | (code & 0x3F));
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

std::size_t line_of(std::string_view text, std::size_t at) {
  return lines_of(text.substr(0, at + 1)).size();
}

}  // namespace

bool is_utf16(std::string_view bytes) {
  return bytes.starts_with("\xff\xfe") || bytes.starts_with("\xfe\xff");
}

std::string utf8_of(const std::filesystem::path& path, std::string_view utf16) {
  const bool is_little = utf16[0] == '\xff';
  const auto unit = [&](std::size_t i) {
    const auto low = static_cast<unsigned char>(utf16[is_little ? i : i + 1]),
               high = static_cast<unsigned char>(utf16[is_little ? i + 1 : i]);
    return static_cast<std::uint32_t>(high << 8 | low);
  };
  std::string text;
  text.reserve(utf16.size());
  for (std::size_t i = 2; i < utf16.size(); i += 2) {
    std::uint32_t code = i + 1 < utf16.size() ? unit(i) : 0xDC00;
    if (code >= 0xD800 && code < 0xDC00 && i + 3 < utf16.size()) {  // the first of two
      const std::uint32_t second = unit(i + 2);
      if (second >= 0xDC00 && second < 0xE000) {
        code = 0x10000 + ((code - 0xD800) << 10) + (second - 0xDC00);
        i += 2;
      }
    }
    if (code >= 0xD800 && code < 0xE000)
      throw Error(fmt::format("{}:{}", path.string(), std::ranges::count(text, '\n') + 1),
                  "is UTF-16 text that is damaged or cut short",
                  "Save it again, or as UTF-8: iconv -f UTF-16 -t UTF-8 does.");
    append_utf8(code, text);
  }
  return text;
}

TextFile::TextFile(const std::filesystem::path& path, std::string_view bytes,
                   std::string_view encoding)
    : path_(path) {
  if (bytes.starts_with(kByteOrderMark)) bytes.remove_prefix(kByteOrderMark.size());
  if (trimmed(bytes).empty())
    throw Error(path.string() + ":1", "is empty",
                "Record it again, or remove it from the manifest.");
  const std::size_t zero = bytes.find('\0');
  const auto controls = static_cast<double>(std::count_if(bytes.begin(), bytes.end(), is_control));
  if (zero != std::string_view::npos ||
      controls > kControlShare * static_cast<double>(bytes.size()))
    throw Error(fmt::format("{}:{}", path.string(),
                            line_of(bytes, zero == std::string_view::npos ? 0 : zero)),
                "is binary data, not text",
                "Export the recording as text, or name its `format` in the manifest.");
  if (encoding == "latin-1") {
    converted_ = from_latin1(bytes);
    bytes = converted_;
  } else if (const std::size_t bad = first_invalid(bytes); bad < bytes.size()) {
    throw Error(fmt::format("{}:{}", path.string(), line_of(bytes, bad)), "is not UTF-8 text",
                "Say encoding = \"latin-1\" in the manifest, or save the file as UTF-8.");
  }
  line_ = lines_of(bytes);
}

Error TextFile::error(std::size_t index, const std::string& what, const std::string& remedy) const {
  return Error(fmt::format("{}:{}", path_.string(), index + 1), what, remedy);
}

Error TextFile::error(const std::string& what, const std::string& remedy) const {
  return Error(path_.string(), what, remedy);
}

std::string_view trimmed(std::string_view text) {
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
      fields.push_back(trimmed(line.substr(0, end)));
      line.remove_prefix(end);
    }
  }
  bool is_quoted = false;
  std::size_t begin = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') is_quoted = !is_quoted;
    if (line[i] != separator || is_quoted) continue;
    fields.push_back(trimmed(line.substr(begin, i - begin)));
    begin = i + 1;
  }
  fields.push_back(trimmed(line.substr(begin)));
  return fields;
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
    return {std::string(trimmed(text.substr(0, from))),
            std::string(trimmed(text.substr(from + 1, text.size() - from - 2)))};
  }
  return {text, {}};
}

namespace {

constexpr std::int64_t kMostTicks = std::int64_t{1} << 53;  // that a double resolves

std::optional<double> tick_of(std::string_view text, std::optional<std::int64_t>& first) {
  std::int64_t ticks = 0, since = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), ticks);
  if (failure != std::errc() || end != text.data() + text.size() ||
      (!first && ticks < kMostTicks && ticks > -kMostTicks))
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
    const std::string_view line = trimmed(file.line(i));
    if (line.empty() || (!layout.comment.empty() && line.starts_with(layout.comment))) continue;
    const auto fields = split(file.line(i), layout.separator);
    const auto is_blank = [&](std::size_t f) { return f >= fields.size() || fields[f].empty(); };
    if (layout.may_end_early && std::all_of(layout.field.begin(), layout.field.end(), is_blank))
      continue;
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
    if (what.empty()) {
      for (std::size_t c = 0; c < row.size(); ++c) table.column[c].push_back(row[c]);
      table.line.push_back(i + 1);
    } else if (layout.drop_invalid) {
      ++table.dropped_rows;
    } else {
      throw file.error(
          i, what,
          "Correct or remove the row, or import with --drop-invalid to skip and count such rows.");
    }
  }
  if (table.line.empty())
    throw file.error("has no row of numbers", "Record it again, or remove it from the manifest.");
  return table;
}

}  // namespace palpate::importers
