// Delimited text: of columns that the manifest or they themselves name, and of palpating robots.

#include <fmt/core.h>

#include <algorithm>

#include "libfit/recordings/formats/importers.hpp"

namespace palpate::importers {
namespace {

constexpr std::size_t kStyleRows = 200;  // that show how numbers are written

struct ColumnsHeader {
  std::size_t line = 0;  // index
  char separator = ',';
  std::vector<std::string> names;
  bool is_numbered = false;  // no header line: the first row of numbers
};

// A header that is commented out, as numpy writes it, without the mark and a label: "# columns: t
// z".
std::string_view uncommented(std::string_view line, const ReadSettings& settings) {
  line = unquoted(line).substr(settings.comment.size());
  const std::size_t colon = line.find(": ");
  const std::string_view label = unquoted(line.substr(0, std::min(colon, line.size())));
  return colon == std::string_view::npos || label.find_first_of(" \t,;") != std::string_view::npos
             ? line
             : line.substr(colon + 2);
}

std::size_t matches(const std::vector<Role>& roles, const std::vector<std::string>& names) {
  return std::ranges::count_if(roles, [&](const Role& role) {
    return std::ranges::any_of(names, [&](const std::string& name) {
      return name == role.name || split_unit(name).first == split_unit(role.name).first;
    });
  });
}

// The line that names most of the columns, the first of equals; without any the first that could be
// a header, for its error.
ColumnsHeader find_header(const TextFile& file, const std::vector<Role>& roles,
                          const ReadSettings& settings) {
  const bool is_numbered =
      std::ranges::all_of(roles, [](const Role& r) { return r.name.starts_with('#'); });
  ColumnsHeader best;
  std::size_t most = 0;
  bool has_one = false;
  for (std::size_t i = 0, seen = 0; i < file.lines() && seen < kHeaderLines; ++i) {
    std::string_view line = file.line(i);
    if (unquoted(line).empty()) continue;
    ++seen;
    if (is_comment(line, settings.comment)) {
      if (is_numbered) continue;
      line = uncommented(line, settings);
    }
    const char separator = settings.separator ? settings.separator : guess_separator(line);
    const auto fields = split(line, separator);
    ColumnsHeader header{i, separator, {fields.begin(), fields.end()}, is_numbered};
    if (is_numbered) {
      const bool is_row = std::ranges::any_of(header.names, [](const std::string& name) {
        return parse_number(name, '.') || parse_number(name, ',');
      });
      if (is_row && header.names.size() > 1) return header;
      continue;
    }
    const std::size_t count = matches(roles, header.names);
    if (count > most || (!has_one && header.names.size() > 1))
      best = header, most = count, has_one = true;
    if (count == roles.size()) break;
  }
  if (best.names.empty() && is_numbered) throw file.error(0, "has no row of numbers", kNoRowRemedy);
  return best;
}

// A line as the names of columns.
std::vector<std::string> names_of_line(std::string_view line, const ReadSettings& settings) {
  if (!settings.comment.empty() && unquoted(line).starts_with(settings.comment))
    line = uncommented(line, settings);
  const auto fields = split(line, settings.separator ? settings.separator : guess_separator(line));
  return {fields.begin(), fields.end()};
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

// Finds how numbers are written, by the first rows: a comma is the decimal sign where it separates
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
    if (is_comment(file.line(i), settings.comment)) continue;
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

// True if positions and forces come in rows of their own, as two topics in one log do.
bool has_two_topics(const TextFile& file, const std::vector<Role>& roles,
                    const std::vector<std::size_t>& field, const TableLayout& layout) {
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
  // Five rows are a signal at the least. With half of the share, readings that were lost would seem
  // to be topics; with twice, two topics that share every second time stamp would not.
  return alone >= 5 && static_cast<double>(alone) >= 1.0 / 3 * static_cast<double>(rows);
}

// A header whose names hold blanks has more fields than its rows, one that leaves out a column of
// row numbers fewer: either would shift them. Half of the first rows may be longer, by notes.
void check_width(const TextFile& file, const ColumnsHeader& header, const ReadSettings& settings) {
  if (header.is_numbered) return;
  std::vector<std::size_t> widths;  // of rows, but for empty fields at their ends
  for (std::size_t i = header.line + 1; i < file.lines() && widths.size() < kStyleRows; ++i) {
    if (is_comment(file.line(i), settings.comment)) continue;
    auto fields = split(file.line(i), header.separator);
    while (!fields.empty() && fields.back().empty()) fields.pop_back();
    widths.push_back(fields.size());
  }
  if (widths.empty()) return;
  const std::size_t names = header.names.size(), first = widths.front();
  const std::string said = "the header names " + std::to_string(names) + " columns, the rows have ";
  if (header.separator == ' ' && names > first)
    throw file.error(header.line, said + std::to_string(first),
                     "Write names without blanks, or name `columns` by number.");
  const auto middle = widths.begin() + (widths.size() - 1) / 2;
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

// A layout without columns.
TableLayout layout_of(const ReadSettings& settings, std::size_t first, char separator) {
  TableLayout layout;
  layout.first = first, layout.separator = separator;
  layout.comment = settings.comment;
  return layout;
}

std::vector<std::string> axes(const std::string& stem) {
  return {stem + "_x", stem + "_y", stem + "_z"};
}

// Names that a manifest may leave out.
ColumnNames with_defaults(ColumnNames names) {
  if (names.contact.empty()) names.contact = axes("contact");
  if (names.normal.empty()) names.normal = axes("normal");
  if (names.force.empty()) names.force = axes("force");
  if (names.position.empty()) names.position = axes("current");
  return names;
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
  TableLayout layout = layout_of(settings, header.line + !header.is_numbered, header.separator);
  check_width(file, header, settings);
  find_number_style(file, header, settings, layout);
  std::optional<std::int64_t> first_tick;
  layout.first_tick = &first_tick;
  auto field = find_columns(roles, header.names, fail);
  std::string topics;
  ColumnNames& asked = settings.columns;
  if (asked.force_time.empty() && has_two_topics(file, roles, field, layout)) {
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
  }
  RawRecording recording =
      recording_of(roles, std::move(columns), factors, std::move(line), settings);
  for (const std::string& what : {taken, topics})
    if (!what.empty()) recording.taken.push_back(what);
  return {recording};
}

// A row per depth, as palpating robots log it: contact point, surface normal, contact force and
// current position. Rows of one contact point follow one another; a file holds many.
std::vector<RawRecording> read_robot_palpation(const std::filesystem::path& path,
                                               std::string_view bytes,
                                               const ReadSettings& settings) {
  const TextFile file(path, bytes, settings.encoding);
  std::size_t header = 0;
  while (header < file.lines() && is_comment(file.line(header), settings.comment)) ++header;
  if (header == file.lines())
    throw file.error(0, "is empty", "The first line must name the columns.");
  const FailColumn fail = [&](const std::string& what, const std::string& remedy) {
    return file.error(header, what, remedy);
  };
  const std::vector<Role> roles = roles_of(with_defaults(settings.columns));
  const std::string_view line_of_names = unquoted(file.line(header));
  const std::vector<std::string> names = names_of_line(line_of_names, settings);
  TableLayout layout =
      layout_of(settings, header + 1,
                settings.separator ? settings.separator : guess_separator(line_of_names));
  layout.decimal = settings.decimal ? settings.decimal : '.';
  layout.field = find_columns(roles, names, fail);
  std::vector<double> factors;
  for (std::size_t i = 0; i < roles.size(); ++i) {
    layout.name.push_back(names[layout.field[i]]);
    factors.push_back(factor_of(roles[i], layout.name[i], settings.units, fail));
  }
  NumberTable table = read_numbers(file, layout);
  for (std::size_t i = 0; i < roles.size(); ++i)
    for (double& value : table.column[i]) value *= factors[i];
  const auto points = [&](Meaning meaning) { return points_of(meaning, roles, table.column); };
  const int of_tool = settings.is_force_on_tool.value_or(false) ? -1 : 1;
  const Points contact = points(Meaning::contact), position = points(Meaning::position),
               normal = points(Meaning::normal) * (settings.is_normal_outward ? -1 : 1),
               force = points(Meaning::force) * of_tool, torque = points(Meaning::torque) * of_tool;
  const std::vector<std::size_t>& line = table.line;

  std::vector<RawRecording> recordings;
  const Eigen::Index rows = contact.rows();
  for (Eigen::Index first = 0, last = 0; first < rows; first = last) {
    last = first;  // rounding of a printed coordinate is no other point
    while (last < rows && (contact.row(last) - contact.row(first)).norm() <= 1e-9) ++last;
    RawRecording r;
    r.name = fmt::format("contact{}", recordings.size() + 1);
    if (!(normal.row(first).norm() > 1e-12)) {  // what robots write of a probe that failed
      r.unread = file.error(line[first] - 1, "the surface normal has no direction",
                            "Correct the row, or remove the probe's rows.");
      recordings.push_back(std::move(r));
      continue;
    }
    r.position_m = position.middleRows(first, last - first);
    r.force_N = force.middleRows(first, last - first);
    if (torque.rows() > 0) r.torque_Nm = torque.middleRows(first, last - first);
    r.line.assign(line.begin() + first, line.begin() + last);
    r.contact_m = Vec3(contact.row(first));
    r.normal = Vec3(normal.row(first)).normalized();
    recordings.push_back(std::move(r));
  }
  if (std::ranges::all_of(recordings, [](const RawRecording& r) { return r.unread.has_value(); }))
    throw *recordings.front().unread;
  return recordings;
}

}  // namespace palpate::importers
