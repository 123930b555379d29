// A row per depth, as palpating robots log it: contact point, surface normal, contact force,
// desired and current position. Rows of one contact point follow one another; a file holds many.

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
  if (names.desired.empty()) names.desired = axes("desired");
  return names;
}

Points columns_of(const NumberTable& table, const std::vector<Role>& roles, Meaning meaning,
                  const std::vector<double>& factors) {
  Points points = Points::Zero(static_cast<Eigen::Index>(table.line.size()), 3);
  for (std::size_t c = 0; c < roles.size(); ++c)
    if (roles[c].meaning == meaning)
      points.col(roles[c].axis) =
          factors[c] * Eigen::Map<const Eigen::VectorXd>(table.column[c].data(), points.rows());
  return points;
}

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

}  // namespace

std::vector<RawRecording> read_robot_palpation(const std::filesystem::path& path,
                                               std::string_view bytes,
                                               const ReadSettings& settings) {
  const TextFile file(path, bytes, settings.encoding);
  const RobotHeader header = header_of(file, settings);
  const FailColumn fail = [&](const std::string& what, const std::string& remedy) {
    return file.error(header.line, what, remedy);
  };
  const auto roles = roles_of(with_defaults(settings.columns));
  TableLayout layout;
  layout.first = header.line + 1;
  layout.separator = header.separator;
  layout.decimal = settings.decimal ? settings.decimal : '.';
  layout.comment = settings.comment;
  layout.drop_invalid = settings.drop_invalid;
  layout.may_end_early = true;
  layout.field = find_columns(roles, header.names, fail);
  std::vector<double> factors;
  for (std::size_t i = 0; i < roles.size(); ++i) {
    layout.name.push_back(header.names[layout.field[i]]);
    factors.push_back(factor_of(roles[i], layout.name[i], settings.units, fail));
  }
  const NumberTable table = read_numbers(file, layout);
  const Points contact = columns_of(table, roles, Meaning::contact, factors);
  const Points normal =
      columns_of(table, roles, Meaning::normal, factors) * (settings.is_normal_outward ? -1 : 1);
  const Points position = columns_of(table, roles, Meaning::position, factors);
  const Points desired = columns_of(table, roles, Meaning::desired, factors);
  const Points force = columns_of(table, roles, Meaning::force, factors) *
                       (settings.is_force_on_tool.value_or(false) ? -1 : 1);

  const Points torque = columns_of(table, roles, Meaning::torque, factors) *
                        (settings.is_force_on_tool.value_or(false) ? -1 : 1);

  std::vector<RawRecording> recordings;
  const Eigen::Index rows = contact.rows();
  for (Eigen::Index first = 0, last = 0; first < rows; first = last) {
    for (last = first;
         last < rows && (contact.row(last) - contact.row(first)).norm() <= kSamePoint_m; ++last) {
    }
    RawRecording r;
    r.name = fmt::format("contact{}", recordings.size() + 1);
    if (!(normal.row(first).norm() > 1e-12)) {  // what robots write of a probe that failed
      r.unread = file.error(table.line[static_cast<std::size_t>(first)] - 1,
                            "the surface normal has no direction",
                            "Correct the row, or remove the probe's rows.");
      recordings.push_back(std::move(r));
      continue;
    }
    r.position_m = position.middleRows(first, last - first);
    r.force_N = force.middleRows(first, last - first);
    if (!settings.columns.torque.empty()) r.torque_Nm = torque.middleRows(first, last - first);
    r.line.assign(table.line.begin() + first, table.line.begin() + last);
    r.contact_m = Vec3(contact.row(first));
    r.normal = Vec3(normal.row(first)).normalized();
    const double error_m =
        (desired - position).middleRows(first, last - first).rowwise().norm().maxCoeff();
    r.facts["largest_tracking_error_m"] = fmt::format("{:f}", error_m);
    recordings.push_back(std::move(r));
  }
  recordings.front().dropped_rows = table.dropped_rows;
  if (std::ranges::all_of(recordings, [](const RawRecording& r) { return r.unread.has_value(); }))
    throw *recordings.front().unread;
  return recordings;
}

}  // namespace palpate::importers
