#include "libfit/io/csv/csv.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cassert>
#include <cctype>
#include <charconv>
#include <cmath>
#include <optional>

#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"

namespace palpate {
namespace {

// Line and column of a field, for errors.
struct Place {
  const std::filesystem::path& path;
  std::size_t line;

  Error error(const std::string& what, const std::string& remedy) const {
    return Error(fmt::format("{}:{}", path.string(), line), what, remedy);
  }
};

// One quoted field from its opening quote; `rest` is left behind the closing one.
std::string take_quoted(std::string_view& rest, const Place& place) {
  std::string field;
  for (std::size_t i = 1; i < rest.size(); ++i) {
    if (rest[i] != '"') {
      field += rest[i];
    } else if (i + 1 < rest.size() && rest[i + 1] == '"') {
      field += rest[i++];
    } else {
      rest = trimmed(rest.substr(i + 1));
      return field;
    }
  }
  throw place.error("a quote is not closed", "Close it on the same line.");
}

std::vector<std::string> split(std::string_view line, const Place& place) {
  std::vector<std::string> fields;
  for (std::string_view rest = line;;) {
    rest = trimmed(rest);
    if (!rest.empty() && rest.front() == '"') {
      fields.push_back(take_quoted(rest, place));
      if (!rest.empty() && rest.front() != ',')
        throw place.error("text follows a closing quote", "Put a comma behind the quote.");
    } else {
      const std::size_t comma = std::min(rest.find(','), rest.size());
      fields.emplace_back(trimmed(rest.substr(0, comma)));
      rest.remove_prefix(comma);
    }
    if (rest.empty()) return fields;
    rest.remove_prefix(1);
  }
}

// A header whose names something else than commas separates, as spreadsheets write it where
// numbers have a decimal comma.
void refuse_other_separators(const std::vector<std::string>& header, const Place& place) {
  if (header.size() != 1) return;
  for (const auto& [separator, name] : {std::pair{';', "semicolons"}, std::pair{'\t', "tabs"}})
    if (header[0].find(separator) != std::string::npos)
      throw place.error(fmt::format("the columns are separated by {}", name),
                        "Separate them by commas, and write numbers with a decimal point: 0.04, "
                        "not 0,04.");
}

// "X_mm" -> "x": what two spellings of a column have in common, whatever their unit.
std::string stem(std::string_view name) {
  std::string lower(name.substr(0, std::min(name.find('_'), name.size())));
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

std::string names_of(std::span<const CsvColumnRule> rules) {
  std::vector<std::string> names;
  for (const auto& rule : rules)
    names.push_back(rule.is_required ? std::string(rule.name) : fmt::format("[{}]", rule.name));
  return fmt::format("{}", fmt::join(names, ","));
}

// A header name that is a known column but for its unit is a mistake, never ignored.
void refuse_near_miss(const std::string& name, const std::vector<std::string>& header,
                      std::span<const CsvColumnRule> rules, const Place& place) {
  for (const auto& rule : rules) {
    const bool is_elsewhere = std::ranges::find(header, rule.name) != header.end();
    if (is_elsewhere || stem(rule.name) != stem(name)) continue;
    const bool lacks_unit =
        name.find('_') == std::string::npos && rule.name.find('_') != std::string::npos;
    throw place.error(
        fmt::format("column `{}` is not `{}`{}", name, rule.name,
                    lacks_unit ? ": it does not say its unit" : ""),
        fmt::format("Give the column in the unit its name says and call it `{}`.", rule.name));
  }
}

// Field index of each rule's column; none for optional ones left out.
std::vector<std::optional<std::size_t>> match_header(const std::vector<std::string>& header,
                                                     std::span<const CsvColumnRule> rules,
                                                     const Place& place, CsvTable& table) {
  for (std::size_t i = 0; i < header.size(); ++i) {
    if (std::ranges::find(rules, header[i], &CsvColumnRule::name) == rules.end()) {
      refuse_near_miss(header[i], header, rules, place);
      table.ignored.push_back(header[i]);
    } else if (std::ranges::find(header, header[i]) != header.begin() + std::ptrdiff_t(i)) {
      throw place.error(fmt::format("column `{}` comes twice", header[i]), "Remove one of them.");
    }
  }
  std::vector<std::optional<std::size_t>> fields;
  for (const auto& rule : rules) {
    const auto at = std::find(header.begin(), header.end(), rule.name);
    if (at == header.end() && rule.is_required)
      throw place.error(
          fmt::format("column `{}` is missing", rule.name),
          fmt::format("The first line must name the columns, separated by commas: {}.",
                      names_of(rules)));
    fields.push_back(at == header.end()
                         ? std::nullopt
                         : std::optional(static_cast<std::size_t>(at - header.begin())));
  }
  return fields;
}

double parse_number(const std::string& field, std::string_view column, const Place& place) {
  std::string_view digits = field;
  if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-') digits.remove_prefix(1);
  double value = 0;
  const auto [end, status] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  const std::string what = fmt::format("column `{}`: `{}` is ", column, field);
  if (status == std::errc::result_out_of_range)
    throw place.error(what + "out of range", "Give a number that a double can hold.");
  if (status != std::errc() || end != digits.data() + digits.size())
    throw place.error(what + "not a number",
                      "Write a number with a decimal point, or remove the row.");
  if (!std::isfinite(value)) throw place.error(what + "not finite", "Remove the row.");
  return value;
}

void append_row(const std::vector<std::string>& fields,
                const std::vector<std::optional<std::size_t>>& field_of,
                std::span<const CsvColumnRule> rules, const Place& place, CsvTable& table) {
  std::size_t column = 0;
  for (std::size_t r = 0; r < rules.size(); ++r) {
    if (!field_of[r]) continue;
    CsvColumn& out = table.columns[column++];
    const std::string& field = fields[*field_of[r]];
    if (rules[r].is_text)
      out.text.push_back(field);
    else
      out.number.push_back(parse_number(field, out.name, place));
  }
  table.line.push_back(place.line);
}

std::string quoted_if_needed(std::string_view value) {
  const bool is_plain = value.find_first_of(",\" \t") == std::string_view::npos && !value.empty();
  if (is_plain) return std::string(value);
  std::string text = "\"";
  for (const char c : value) text += c == '"' ? "\"\"" : std::string(1, c);
  return text + '"';
}

}  // namespace

bool CsvTable::has(std::string_view name) const {
  return std::ranges::find(columns, name, &CsvColumn::name) != columns.end();
}

const std::vector<double>& CsvTable::number(std::string_view name) const {
  return std::ranges::find(columns, name, &CsvColumn::name)->number;
}

const std::vector<std::string>& CsvTable::text(std::string_view name) const {
  return std::ranges::find(columns, name, &CsvColumn::name)->text;
}

CsvTable read_csv(const std::filesystem::path& path, std::span<const CsvColumnRule> rules) {
  const std::string bytes = read_whole_file(path);
  CsvTable table;
  table.path = path;
  std::vector<std::string> header;
  std::vector<std::optional<std::size_t>> field_of;
  std::string_view rest = bytes;
  if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);  // a byte-order mark
  for (std::size_t line = 1; !rest.empty(); ++line) {
    const Place place{path, line};
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    std::string_view text = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (text.ends_with('\r')) text.remove_suffix(1);
    if (trimmed(text).empty()) continue;
    const auto fields = split(text, place);
    if (header.empty()) {
      header = fields;
      refuse_other_separators(header, place);
      field_of = match_header(header, rules, place, table);
      for (std::size_t r = 0; r < rules.size(); ++r)
        if (field_of[r]) table.columns.push_back({std::string(rules[r].name), {}, {}});
    } else if (fields.size() != header.size()) {
      throw place.error(
          fmt::format("has {} fields where the header has {}", fields.size(), header.size()),
          "Complete the row, or remove it. Numbers take a decimal point, no comma.");
    } else {
      append_row(fields, field_of, rules, place, table);
    }
  }
  if (header.empty())
    throw Error(path.string() + ":1", "is empty",
                fmt::format("The first line must name the columns: {}.", names_of(rules)));
  return table;
}

CsvWriter::CsvWriter(const std::filesystem::path& path, std::span<const std::string_view> header)
    : path_(path), file_(path), columns_(header.size()) {
  for (const std::string_view name : header) text(name);
  end_row();
  row_ = 0;
}

void CsvWriter::separate() {
  assert(field_ < columns_);
  if (field_++ > 0) line_ += ',';
}

CsvWriter& CsvWriter::number(double value) {
  if (!std::isfinite(value))
    throw Error(path_.string(),
                fmt::format("row {} field {} would not be a finite number", row_, field_ + 1),
                "Not written; report how it was made.");
  separate();
  line_ += to_text(value);
  return *this;
}

CsvWriter& CsvWriter::integer(long long value) {
  separate();
  line_ += std::to_string(value);
  return *this;
}

CsvWriter& CsvWriter::text(std::string_view value) {
  if (value.find_first_of("\r\n") != std::string_view::npos)
    throw Error(path_.string(), "a text field holds a line break", "Take it out of the name.");
  separate();
  line_ += quoted_if_needed(value);
  return *this;
}

void CsvWriter::end_row() {
  assert(field_ == columns_);
  line_ += '\n';
  file_.write(line_);
  line_.clear();
  field_ = 0;
  ++row_;
}

void CsvWriter::commit() { file_.commit(); }

}  // namespace palpate
