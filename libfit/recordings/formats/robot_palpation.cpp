// A row per depth, as palpating robots log it: contact point, surface normal, contact force and
// current position. Rows of one contact point follow one another; a file holds many.

#include "libfit/recordings/formats/columns.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "libfit/recordings/formats/importers.hpp"

namespace palpate::importers {
namespace {

constexpr double kSamePoint_m = 1e-9;  // rounding of a printed coordinate

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

struct RobotTable {
  std::vector<Role> roles;
  std::vector<double> factors;  // to SI, of each role's column
  NumberTable numbers;

  Points of(Meaning meaning) const {
    Points points = Points::Zero(numbers.line.size(), 3);
    for (std::size_t c = 0; c < roles.size(); ++c)
      if (roles[c].meaning == meaning)
        points.col(roles[c].axis) =
            factors[c] * Eigen::Map<const Eigen::VectorXd>(numbers.column[c].data(), points.rows());
    return points;
  }
};

struct RobotHeader {
  std::size_t line = 0;
  char separator = ',';
  std::vector<std::string> names;
};

RobotHeader header_of(const TextFile& file, const ReadSettings& settings) {
  for (std::size_t i = 0; i < file.lines(); ++i) {
    const std::string_view line = trimmed(file.line(i));
    if (line.empty() || (!settings.comment.empty() && line.starts_with(settings.comment))) continue;
    RobotHeader header{i, settings.separator ? settings.separator : guess_separator(line), {}};
    for (const auto field : split(line, header.separator)) header.names.emplace_back(field);
    return header;
  }
  throw file.error(0, "is empty", "The first line must name the columns.");
}

RobotTable read_table(const TextFile& file, const ReadSettings& settings) {
  const RobotHeader header = header_of(file, settings);
  const FailColumn fail = [&](const std::string& what, const std::string& remedy) {
    return file.error(header.line, what, remedy);
  };
  RobotTable out{roles_of(with_defaults(settings.columns)), {}, {}};
  TableLayout layout;
  layout.first = header.line + 1;
  layout.separator = header.separator;
  layout.decimal = settings.decimal ? settings.decimal : '.';
  layout.comment = settings.comment;
  layout.drop_invalid = settings.drop_invalid;
  layout.may_end_early = true;
  layout.field = find_columns(out.roles, header.names, fail);
  for (std::size_t i = 0; i < out.roles.size(); ++i) {
    layout.name.push_back(header.names[layout.field[i]]);
    out.factors.push_back(factor_of(out.roles[i], layout.name[i], settings.units, fail));
  }
  out.numbers = read_numbers(file, layout);
  return out;
}

}  // namespace

std::vector<RawRecording> read_robot_palpation(const std::filesystem::path& path,
                                               std::string_view bytes,
                                               const ReadSettings& settings) {
  const TextFile file(path, bytes, settings.encoding);
  const RobotTable table = read_table(file, settings);
  const int of_tool = settings.is_force_on_tool.value_or(false) ? -1 : 1;
  const Points contact = table.of(Meaning::contact);
  const Points normal = table.of(Meaning::normal) * (settings.is_normal_outward ? -1 : 1);
  const Points position = table.of(Meaning::position);
  const Points force = table.of(Meaning::force) * of_tool,
               torque = table.of(Meaning::torque) * of_tool;
  const std::vector<std::size_t>& line = table.numbers.line;

  std::vector<RawRecording> recordings;
  const Eigen::Index rows = contact.rows();
  for (Eigen::Index first = 0, last = 0; first < rows; first = last) {
    for (last = first;
         last < rows && (contact.row(last) - contact.row(first)).norm() <= kSamePoint_m; ++last) {
    }
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
    if (!settings.columns.torque.empty()) r.torque_Nm = torque.middleRows(first, last - first);
    r.line.assign(line.begin() + first, line.begin() + last);
    r.contact_m = Vec3(contact.row(first));
    r.normal = Vec3(normal.row(first)).normalized();
    recordings.push_back(std::move(r));
  }
  recordings.front().dropped_rows = table.numbers.dropped_rows;
  if (std::ranges::all_of(recordings, [](const RawRecording& r) { return r.unread.has_value(); }))
    throw *recordings.front().unread;
  return recordings;
}

}  // namespace palpate::importers
