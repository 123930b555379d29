// Any delimited text whose columns the manifest names.

#include <algorithm>

#include "libfit/recordings/formats/columns.hpp"
#include "libfit/recordings/formats/importers.hpp"

namespace palpate::importers {
namespace {

constexpr std::size_t kHeaderLines = 400;  // a preamble is shorter
constexpr std::size_t kStyleRows = 200;    // that show how numbers are written

bool is_comment(std::string_view line, const ReadSettings& settings) {
  return trimmed(line).empty() ||
         (!settings.comment.empty() && trimmed(line).starts_with(settings.comment));
}

struct ColumnsHeader {
  std::size_t line = 0;  // index
  char separator = ',';
  std::vector<std::string> names;
  bool is_numbered = false;  // no header line: the first row of numbers
};

// A header that is commented out, as numpy writes it, without the mark and a label: "# columns: t
// z".
std::string_view uncommented(std::string_view line, const ReadSettings& settings) {
  line = trimmed(line).substr(settings.comment.size());
  const std::size_t colon = line.find(": ");
  const std::string_view label = trimmed(line.substr(0, std::min(colon, line.size())));
  return colon == std::string_view::npos || label.find_first_of(" \t,;") != std::string_view::npos
             ? line
             : line.substr(colon + 2);
}

std::vector<std::string> names_in(std::string_view line, char separator) {
  std::vector<std::string> names;
  for (const auto field : split(line, separator)) names.emplace_back(field);
  return names;
}

std::size_t matches(const std::vector<Role>& roles, const std::vector<std::string>& names) {
  return static_cast<std::size_t>(std::count_if(roles.begin(), roles.end(), [&](const Role& role) {
    return std::any_of(names.begin(), names.end(), [&](const std::string& name) {
      return name == role.name || split_unit(name).first == split_unit(role.name).first;
    });
  }));
}

// The line that names most of the columns, the first of equals; without any the first that could be
// a header, for its error.
ColumnsHeader find_header(const TextFile& file, const std::vector<Role>& roles,
                          const ReadSettings& settings) {
  const bool is_numbered = std::all_of(roles.begin(), roles.end(),
                                       [](const Role& r) { return r.name.starts_with('#'); });
  ColumnsHeader best;
  std::size_t most = 0;
  bool has_one = false;
  for (std::size_t i = 0, seen = 0; i < file.lines() && seen < kHeaderLines; ++i) {
    std::string_view line = file.line(i);
    // A header may itself be commented out, as numpy writes it.
    if (trimmed(line).empty()) continue;
    ++seen;
    if (is_comment(line, settings)) {
      if (is_numbered) continue;
      line = uncommented(line, settings);
    }
    const char separator = settings.separator ? settings.separator : guess_separator(line);
    ColumnsHeader header{i, separator, names_in(line, separator), is_numbered};
    if (is_numbered) {
      const bool is_row =
          std::any_of(header.names.begin(), header.names.end(), [](const std::string& name) {
            return parse_number(name, '.') || parse_number(name, ',');
          });
      if (is_row && header.names.size() > 1) return header;
      continue;
    }
    const std::size_t count = matches(roles, header.names);
    if (count > most || (!has_one && header.names.size() > 1)) {
      best = header;
      most = count;
      has_one = true;
    }
    if (count == roles.size()) break;
  }
  if (best.names.empty() && is_numbered)
    throw file.error(0, "has no row of numbers",
                     "Record it again, or remove it from the manifest.");
  return best;
}

// A line as the names of columns.
std::vector<std::string> names_of_line(std::string_view line, const ReadSettings& settings) {
  if (!settings.comment.empty() && trimmed(line).starts_with(settings.comment))
    line = uncommented(line, settings);
  return names_in(line, settings.separator ? settings.separator : guess_separator(line));
}

// With the columns of the first line that names them by quantity and unit, where none are asked
// for.
ReadSettings named_by_header(const TextFile& file, const ReadSettings& settings,
                             std::string& taken) {
  if (!roles_of(settings.columns).empty()) return settings;
  const std::size_t lines = std::min(file.lines(), kHeaderLines);
  std::size_t i = 0;
  while (i < lines && columns_named(names_of_line(file.line(i), settings)).columns.force.empty())
    ++i;
  const FailColumn fail = [&](const std::string& what, const std::string& remedy) {
    return file.error(i == lines ? 0 : i, what, remedy);
  };
  if (i == lines)
    throw fail("no column is named",
               "Name columns = { time = ..., depth = ..., force = ... } in the manifest, or in a "
               "header with their units: t_s, x_mm, F_N.");
  return with_named_columns(settings, names_of_line(file.line(i), settings), fail, taken);
}

// How numbers are written, as the first rows show: a comma is the decimal sign where it separates
// no fields and one number has it elsewhere than before three digits. Where all have it there,
// points elsewhere show that it groups digits.
void find_number_style(const TextFile& file, const ColumnsHeader& header,
                       const ReadSettings& settings, TableLayout& layout) {
  layout.decimal = settings.decimal ? settings.decimal : '.';
  layout.has_groups = settings.decimal != 0;
  if (settings.decimal) return;
  bool has_point = false;
  std::optional<std::pair<std::size_t, std::string>> grouped;
  for (std::size_t i = layout.first, seen = 0; i < file.lines() && seen < kStyleRows; ++i) {
    if (is_comment(file.line(i), settings)) continue;
    ++seen;
    for (const auto field : split(file.line(i), header.separator)) {
      if (field.find(',') == std::string_view::npos) {
        has_point |= field.find('.') != std::string_view::npos && parse_number(field, '.');
      } else if (without_groups(field, ',')) {
        has_point |= field.find('.') != std::string_view::npos;
        if (!grouped) grouped = {i, std::string(field)};
      } else if (parse_number(field, ',') || without_groups(field, '.')) {
        layout.decimal = ',';
        return;
      }
    }
  }
  if (grouped && !has_point)
    throw file.error(grouped->first, "`" + grouped->second + "` may be a decimal or a thousand",
                     "Say decimal = \",\" or decimal = \".\" in the manifest.");
  layout.has_groups = grouped.has_value();
}

bool is_of_force(Meaning meaning) {
  return meaning == Meaning::force_time || meaning == Meaning::force || meaning == Meaning::torque;
}

// Whether positions and forces come in rows of their own, as two topics in one log do.
bool has_two_topics(const TextFile& file, const std::vector<Role>& roles,
                    const std::vector<std::size_t>& field, const TableLayout& layout) {
  // Share of rows that have one of them alone. With half of it, readings that were lost would seem
  // to be topics; with twice, two topics that share every second time stamp would not.
  constexpr double kAlone = 1.0 / 3;
  constexpr std::size_t kMinAlone = 5;  // rows, as a signal has at the least
  std::size_t rows = 0, alone = 0;
  for (std::size_t i = layout.first; i < file.lines() && rows < kStyleRows; ++i) {
    const auto fields = split(file.line(i), layout.separator);
    bool has_position = false, has_force = false;
    for (std::size_t r = 0; r < roles.size(); ++r) {
      if (field[r] >= fields.size() || is_blank_field(fields[field[r]])) continue;
      has_force |= is_of_force(roles[r].meaning);
      has_position |= roles[r].meaning == Meaning::depth || roles[r].meaning == Meaning::position;
    }
    rows += has_position || has_force;
    alone += has_position != has_force;
  }
  return alone >= kMinAlone && static_cast<double>(alone) >= kAlone * static_cast<double>(rows);
}

// Counts the fields of a row but for empty ones at its end.
std::size_t count_fields(std::string_view row, char separator) {
  const auto fields = split(row, separator);
  return static_cast<std::size_t>(
      std::find_if(fields.rbegin(), fields.rend(), [](auto field) { return !field.empty(); })
          .base() -
      fields.begin());
}

// A header whose names hold blanks has more fields than its rows, one that leaves out a column of
// row numbers fewer: either would shift them. Half of the first rows may be longer, by notes.
void check_width(const TextFile& file, const ColumnsHeader& header, const ReadSettings& settings) {
  if (header.is_numbered) return;
  std::vector<std::size_t> widths;
  for (std::size_t i = header.line + 1; i < file.lines() && widths.size() < kStyleRows; ++i)
    if (!is_comment(file.line(i), settings))
      widths.push_back(count_fields(file.line(i), header.separator));
  if (widths.empty()) return;
  const std::size_t names = header.names.size(), first = widths.front();
  const std::string said = "the header names " + std::to_string(names) + " columns, the rows have ";
  if (header.separator == ' ' && names > first)
    throw file.error(header.line, said + std::to_string(first),
                     "Write names without blanks, or name `columns` by number.");
  const auto middle = widths.begin() + static_cast<std::ptrdiff_t>((widths.size() - 1) / 2);
  std::nth_element(widths.begin(), middle, widths.end());
  if (*middle <= names) return;
  const bool has_commas = header.separator == ',' && *middle == 2 * names;
  throw file.error(header.line,
                   said + std::to_string(*middle) +
                       (has_commas ? ": a comma separates fields and is the decimal sign" : ""),
                   has_commas ? "Export with decimal points, or with semicolons between fields."
                              : "Name all columns in the header, that of row numbers too, or name "
                                "`columns` by number.");
}

}  // namespace

bool begins_named_columns(std::string_view head) {
  for (std::size_t lines = 0; lines < kHeaderLines && !head.empty(); ++lines) {
    const std::size_t end = std::min(head.find_first_of("\r\n"), head.size());
    if (!columns_named(names_of_line(head.substr(0, end), {})).columns.force.empty()) return true;
    head.remove_prefix(std::min(end + 1, head.size()));
  }
  return false;
}

std::vector<RawRecording> read_columns_csv(const std::filesystem::path& path,
                                           std::string_view bytes, const ReadSettings& given) {
  const TextFile file(path, bytes, given.encoding);
  std::string taken;
  ReadSettings settings = named_by_header(file, given, taken);
  auto roles = roles_of(settings.columns);
  const ColumnsHeader header = find_header(file, roles, settings);
  const FailColumn fail = [&](const std::string& what, const std::string& remedy) {
    return file.error(header.line, what, remedy);
  };
  TableLayout layout;
  layout.first = header.line + !header.is_numbered;
  layout.separator = header.separator;
  check_width(file, header, settings);
  find_number_style(file, header, settings, layout);
  std::optional<std::int64_t> first_tick;
  layout.first_tick = &first_tick;
  layout.comment = settings.comment;
  layout.drop_invalid = settings.drop_invalid;
  layout.may_end_early = true;
  auto field = find_columns(roles, header.names, fail);
  std::string topics;
  ColumnNames& asked = settings.columns;
  if (asked.force_time.empty() && asked.retract_depth.empty() &&
      has_two_topics(file, roles, field, layout)) {
    if (asked.time.empty())
      throw fail("positions and forces are in rows of their own, and no time says how they belong",
                 "Name the time column in the manifest: columns = { time = ... }.");
    asked.force_time = asked.time;
    topics =
        "positions and forces are in rows of their own: positions are interpolated at the "
        "times of the forces";
    roles = roles_of(asked);
    field = find_columns(roles, header.names, fail);
  }
  layout.shares_clock = !asked.time.empty() && asked.force_time == asked.time;
  std::vector<double> factors;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < roles.size(); ++i) {
    names.push_back(header.is_numbered ? roles[i].name : header.names[field[i]]);
    factors.push_back(factor_of(roles[i], names[i], settings.units, fail));
  }
  // With a clock of its own the force has rows of its own: fewer or more, blank where it has none.
  const auto has_force_rows = [&](std::size_t i) {
    return !asked.force_time.empty() && is_of_force(roles[i].meaning);
  };
  std::vector<std::vector<double>> columns(roles.size());
  std::vector<std::size_t> line;
  std::size_t dropped = 0;
  for (const bool is_force : {false, true}) {
    std::vector<std::size_t> part;
    for (std::size_t i = 0; i < roles.size(); ++i)
      if (has_force_rows(i) == is_force) part.push_back(i);
    if (part.empty()) continue;
    layout.field.clear(), layout.name.clear(), layout.is_clock.clear();
    for (const std::size_t i : part) {
      layout.field.push_back(field[i]);
      layout.name.push_back(names[i]);
      layout.is_clock.push_back(roles[i].meaning == Meaning::time ||
                                roles[i].meaning == Meaning::force_time);
    }
    NumberTable table = read_numbers(file, layout);
    for (std::size_t c = 0; c < part.size(); ++c) columns[part[c]] = std::move(table.column[c]);
    if (!is_force) line = std::move(table.line);
    dropped += table.dropped_rows;
  }
  RawRecording recording =
      recording_of(roles, std::move(columns), factors, std::move(line), settings);
  recording.dropped_rows = dropped;
  for (const std::string& what : {taken, topics})
    if (!what.empty()) recording.taken.push_back(what);
  return {recording};
}

}  // namespace palpate::importers
