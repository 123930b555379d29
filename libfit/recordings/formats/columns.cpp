#include "libfit/recordings/formats/columns.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace palpate::importers {
namespace {

constexpr double kLargestNumber = 1e15;  // as in text files

struct Quantity {
  std::string UnitNames::*unit;
  const char* key;
  Dimension dimension;
};

std::optional<Quantity> quantity_of(Meaning meaning) {
  switch (meaning) {
    case Meaning::time:
    case Meaning::force_time:
      return Quantity{&UnitNames::time, "time", Dimension::time};
    case Meaning::force:
    case Meaning::retract_force:
      return Quantity{&UnitNames::force, "force", Dimension::force};
    case Meaning::torque:
      return Quantity{&UnitNames::torque, "torque", Dimension::torque};
    case Meaning::normal:
      return std::nullopt;
    default:
      return Quantity{&UnitNames::position, "position", Dimension::length};
  }
}

std::string listed(const std::vector<std::string>& names) {
  std::string list;
  for (std::size_t i = 0; i < names.size() && i < 12; ++i)
    list += (i ? ", " : "") + names[i].substr(0, 40);
  return list + (names.size() > 12 ? ", ..." : "");
}

// The known unit of an SI value; empty where there is none.
std::string unit_worth(double factor, Dimension dimension) {
  const std::string known = known_units(dimension);
  for (const auto name : split(known, ','))
    if (unit_factor(name, dimension) == factor) return std::string(name);
  return {};
}

// The columns of one meaning, side by side.
struct Collected {
  std::vector<const std::vector<double>*> time, force_time, depth, position, force, retract_depth,
      retract_force, contact, normal, torque;
};

Points as_points(const std::vector<const std::vector<double>*>& axes) {
  if (axes.size() != 3) return Points(0, 3);
  Points points(static_cast<Eigen::Index>(axes[0]->size()), 3);
  for (int k = 0; k < 3; ++k)
    points.col(k) = Eigen::Map<const Eigen::VectorXd>(axes[k]->data(), points.rows());
  return points;
}

void append(std::vector<double>& out, const std::vector<const std::vector<double>*>& column) {
  if (!column.empty()) out.insert(out.end(), column[0]->begin(), column[0]->end());
}

}  // namespace

std::vector<Role> roles_of(const ColumnNames& names) {
  std::vector<Role> roles;
  const auto add = [&](Meaning meaning, const std::string& name, int axis = 0) {
    if (name.empty()) return;
    const bool is_negated = name.front() == '-' && name.size() > 1;
    roles.push_back({meaning, axis, is_negated ? name.substr(1) : name, is_negated ? -1.0 : 1.0});
  };
  const auto add_axes = [&](Meaning meaning, const std::vector<std::string>& axes) {
    for (std::size_t k = 0; k < axes.size(); ++k) add(meaning, axes[k], static_cast<int>(k));
  };
  add(Meaning::time, names.time), add(Meaning::force_time, names.force_time);
  add(Meaning::depth, names.depth);
  add_axes(Meaning::position, names.position), add_axes(Meaning::force, names.force);
  add(Meaning::retract_depth, names.retract_depth),
      add(Meaning::retract_force, names.retract_force);
  add_axes(Meaning::contact, names.contact), add_axes(Meaning::normal, names.normal);
  add_axes(Meaning::torque, names.torque);
  return roles;
}

std::vector<std::size_t> find_columns(const std::vector<Role>& roles,
                                      const std::vector<std::string>& header,
                                      const FailColumn& fail) {
  std::vector<std::size_t> fields;
  for (const Role& role : roles) {
    std::vector<std::size_t> found;
    if (role.name.starts_with('#')) {
      const auto number = parse_number(std::string_view(role.name).substr(1), '.');
      if (number && *number >= 1 && *number <= static_cast<double>(header.size()))
        found.push_back(static_cast<std::size_t>(*number) - 1);
    }
    for (std::size_t i = 0; i < header.size(); ++i)
      if (header[i] == role.name) found.push_back(i);
    for (std::size_t i = 0; found.empty() && i < header.size(); ++i)
      if (split_unit(header[i]).first == split_unit(role.name).first) {
        found.push_back(i);
        for (std::size_t j = i + 1; j < header.size(); ++j)
          if (split_unit(header[j]).first == split_unit(role.name).first) found.push_back(j);
      }
    if (found.empty())
      throw fail("column `" + role.name + "` is missing",
                 "Name it as the header does, under `columns` of the manifest. There are: " +
                     listed(header) + ".");
    if (found.size() > 1)
      throw fail(
          "column `" + role.name + "` comes twice",
          fmt::format("Rename one of them, or give the column by its number, such as \"#{}\".",
                      found[0] + 1));
    fields.push_back(found[0]);
  }
  return fields;
}

double factor_of(const Role& role, const std::string& header_name, const UnitNames& units,
                 const FailColumn& fail) {
  const auto quantity = quantity_of(role.meaning);
  if (!quantity) return role.sign;
  const std::string& given = units.*(quantity->unit);
  std::string written = split_unit(header_name).second;
  if (const std::string behind = header_name.substr(header_name.rfind('_') + 1);
      written.empty() && behind.size() < header_name.size() &&
      unit_factor(behind, quantity->dimension))
    written = behind;
  const auto by_header = unit_factor(written, quantity->dimension);
  const std::string column = "column `" + header_name + "`";
  if (given.empty()) {
    if (by_header) return role.sign * *by_header;
    throw fail(column + (written.empty() ? " has no unit"
                                         : " is in `" + written + "`, which is no unit of " +
                                               std::string(dimension_name(quantity->dimension))),
               "Say units." + std::string(quantity->key) +
                   " in the manifest: " + known_units(quantity->dimension) + ".");
  }
  const auto by_settings = unit_factor(split_unit("(" + given + ")").second, quantity->dimension);
  if (!by_settings)
    throw fail("units." + std::string(quantity->key) + " is `" + given + "`, which is not known",
               "Known: " + known_units(quantity->dimension) + ".");
  if (by_header && *by_header != *by_settings)
    throw fail(column + " is in " + written + ", the manifest says " + given,
               "Correct units." + std::string(quantity->key) + ", or leave it out.");
  return role.sign * *by_settings;
}

RawRecording recording_of(const std::vector<Role>& roles, std::vector<std::vector<double>> columns,
                          const std::vector<double>& factors, std::vector<std::size_t> line,
                          const ReadSettings& settings) {
  const double sign = settings.is_force_on_tool.value_or(false) ? -1 : 1;
  RawRecording recording;
  Collected c;
  std::vector<std::vector<const std::vector<double>*>*> slot;
  slot = {&c.time,          &c.force_time,    &c.depth,   &c.position, &c.force,
          &c.retract_depth, &c.retract_force, &c.contact, &c.normal,   &c.torque};
  for (std::size_t i = 0; i < roles.size(); ++i) {
    const bool is_force = roles[i].meaning == Meaning::force ||
                          roles[i].meaning == Meaning::retract_force ||
                          roles[i].meaning == Meaning::torque;
    const double factor = factors[i] * (is_force ? sign : 1);
    if (const auto quantity = quantity_of(roles[i].meaning))
      recording.units.*(quantity->unit) = unit_worth(std::abs(factor), quantity->dimension);
    for (double& value : columns[i]) value *= factor;
    slot[static_cast<int>(roles[i].meaning)]->push_back(&columns[i]);
  }
  append(recording.time_s, c.time), append(recording.force_time_s, c.force_time);
  recording.position_m = as_points(c.position);
  append(recording.travel_m, c.depth);
  recording.line = std::move(line);
  if (c.force.size() == 3)
    recording.force_N = as_points(c.force);
  else
    append(recording.push_N, c.force);
  recording.torque_Nm = as_points(c.torque);
  if (!c.retract_depth.empty()) {  // the way back follows the way in
    recording.retract_begins = recording.rows();
    const std::ptrdiff_t in_rows = recording.rows();
    append(recording.travel_m, c.retract_depth), append(recording.push_N, c.retract_force);
    const std::vector<std::size_t> lines = recording.line;
    recording.line.insert(recording.line.end(), lines.begin(), lines.end());
    const auto& travel_m = recording.travel_m;
    const double deepest_m = travel_m[static_cast<std::size_t>(in_rows) - 1];
    if (std::abs(travel_m.back() - deepest_m) < std::abs(travel_m[in_rows] - deepest_m)) {
      std::reverse(recording.travel_m.begin() + in_rows, recording.travel_m.end());
      std::reverse(recording.push_N.begin() + in_rows, recording.push_N.end());
      std::reverse(recording.line.begin() + in_rows, recording.line.end());
      recording.taken.push_back("the way back is written from its free end, and was turned around");
    }
    recording.time_s.clear();  // one clock cannot serve both
  }
  return recording;
}

RawRecording recording_of_arrays(const std::vector<Role>& roles,
                                 std::vector<std::vector<double>> columns,
                                 const std::vector<double>& factors, const ReadSettings& settings,
                                 const FailRole& fail) {
  const std::size_t before = columns[0].size();
  for (std::size_t c = 0; c < columns.size(); ++c)
    if (columns[c].size() != before)
      throw fail(roles[c],
                 fmt::format("has {} rows, {} has {}", columns[c].size(), roles[0].name, before),
                 "Give columns of one length.");
  std::optional<double> first_tick;  // of clocks that count from a time long past
  for (std::size_t c = 0; c < columns.size(); ++c)
    if ((roles[c].meaning == Meaning::time || roles[c].meaning == Meaning::force_time) &&
        before > 0 && std::isfinite(columns[c][0]) && std::abs(columns[c][0]) > kLargestNumber) {
      first_tick = first_tick.value_or(columns[c][0]);
      for (double& tick : columns[c]) tick -= *first_tick;
    }
  std::vector<std::size_t> line;
  for (std::size_t i = 0; i < before; ++i) {
    bool is_usable = true;
    for (std::size_t c = 0; c < columns.size(); ++c) {
      if (std::abs(columns[c][i]) <= kLargestNumber) continue;
      if (!settings.drop_invalid)
        throw fail(roles[c], fmt::format("row {} is not a number in range", i + 1),
                   "Correct or remove the row, or import with --drop-invalid to skip and count "
                   "such rows.");
      is_usable = false;
    }
    if (is_usable) line.push_back(i + 1);
  }
  if (line.empty())
    throw fail(roles[0], "has no row of numbers",
               "Record it again, or remove it from the manifest.");
  for (auto& column : columns) {
    for (std::size_t i = 0; i < line.size(); ++i) column[i] = column[line[i] - 1];
    column.resize(line.size());
  }
  const std::size_t rows = line.size();
  RawRecording recording =
      recording_of(roles, std::move(columns), factors, std::move(line), settings);
  recording.dropped_rows = before - rows;
  return recording;
}

}  // namespace palpate::importers
