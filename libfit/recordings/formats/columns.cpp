// Columns by their names: quantity and unit.

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "libfit/core/text.hpp"
#include "libfit/recordings/formats/importers.hpp"

namespace palpate::importers {
namespace {

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
      return Quantity{&UnitNames::force, "force", Dimension::force};
    case Meaning::torque:
      return Quantity{&UnitNames::torque, "torque", Dimension::torque};
    case Meaning::normal:
      return std::nullopt;
    default:
      return Quantity{&UnitNames::position, "position", Dimension::length};
  }
}

std::string some_of(const std::vector<std::string>& names) {
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

// The names of a quantity, in small letters; the first that a header has is taken.
struct Stem {
  Meaning meaning;
  int axis;                ///< -1: of one axis alone
  std::string_view names;  ///< with blanks between; English, German, French, Spanish, Italian
};
constexpr auto kStems = std::to_array<Stem>({
    {Meaning::time, -1, "t time clock zeit temps tiempo tempo"},
    {Meaning::depth, -1,
     "depth indentation travel displacement compression d weg tiefe "
     "eindringtiefe verfahrweg profondeur d\xC3\xA9placement deplacement "
     "enfoncement profundidad desplazamiento profondit\xC3\xA0 profondita "
     "spostamento"},
    {Meaning::position, 0, "x px pos_x position_x tip_x"},
    {Meaning::position, 1, "y py pos_y position_y tip_y"},
    {Meaning::position, 2, "z pz pos_z position_z tip_z"},
    {Meaning::force, -1,
     "f force load push normal_force kraft normalkraft last effort charge "
     "fuerza carga forza carico"},
    {Meaning::force, 0, "fx f_x force_x"},
    {Meaning::force, 1, "fy f_y force_y"},
    {Meaning::force, 2, "fz f_z force_z"},
    {Meaning::torque, 0, "tx torque_x mx"},
    {Meaning::torque, 1, "ty torque_y my"},
    {Meaning::torque, 2, "tz torque_z mz"},
});

std::string in_small_letters(std::string text) {
  for (char& c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return text;
}

// "x_mm" or "x (mm)": {"x", "mm"}; in small letters but for the unit.
std::pair<std::string, std::string> stem_and_unit(const std::string& name) {
  auto [stem, unit] = split_unit(name);
  if (unit.empty()) {
    const std::size_t at = stem.rfind('_');
    if (at == std::string::npos) return {};
    unit = stem.substr(at + 1);
    stem.resize(at);
  }
  return {in_small_letters(std::move(stem)), unit};
}

const Stem* stem_named(const std::string& stem) {
  const auto row =
      std::ranges::find_if(kStems, [&](const Stem& known) { return has_word(known.names, stem); });
  return row == kStems.end() ? nullptr : &*row;
}

// Names of a header by what they are.
struct QuantityNames {
  std::vector<std::string> alone;    // of one axis
  std::vector<std::string> axes[3];  // of each axis
  std::vector<std::string> odd;      // with what is no unit of it

  bool has_three() const { return !axes[0].empty() && !axes[1].empty() && !axes[2].empty(); }
  bool is_empty() const {
    return alone.empty() && axes[0].empty() && axes[1].empty() && axes[2].empty();
  }
  // What names one axis: itself, else whatever axis there is.
  std::vector<std::string> any() const {
    if (!alone.empty()) return alone;
    std::vector<std::string> names;
    for (const auto& axis : axes) names.insert(names.end(), axis.begin(), axis.end());
    return names;
  }
};

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
    const bool is_whole = !found.empty();
    for (std::size_t i = 0; !is_whole && i < header.size(); ++i)
      if (split_unit(header[i]).first == split_unit(role.name).first) found.push_back(i);
    if (found.empty())
      throw fail("column `" + role.name + "` is missing",
                 "Name it as the header does, under `columns` of the manifest. There are: " +
                     some_of(header) + ".");
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

Points points_of(Meaning meaning, const std::vector<Role>& roles,
                 const std::vector<std::vector<double>>& columns) {
  Points points(0, 3);
  for (std::size_t c = 0; c < roles.size(); ++c) {
    if (roles[c].meaning != meaning) continue;
    if (points.rows() == 0) points.setZero(columns[c].size(), 3);
    points.col(roles[c].axis) = Eigen::Map<const Eigen::VectorXd>(columns[c].data(), points.rows());
  }
  return points;
}

RawRecording recording_of(const std::vector<Role>& roles, std::vector<std::vector<double>> columns,
                          const std::vector<double>& factors, std::vector<std::size_t> line,
                          const ReadSettings& settings) {
  const double sign = settings.is_force_on_tool.value_or(false) ? -1 : 1;
  RawRecording recording;
  for (std::size_t i = 0; i < roles.size(); ++i) {
    const bool is_force = roles[i].meaning == Meaning::force || roles[i].meaning == Meaning::torque;
    const double factor = factors[i] * (is_force ? sign : 1);
    if (const auto quantity = quantity_of(roles[i].meaning))
      recording.units.*(quantity->unit) = unit_worth(std::abs(factor), quantity->dimension);
    for (double& value : columns[i]) value *= factor;
  }
  const auto append = [&](Meaning meaning, std::vector<double>& out) {
    const auto at = std::ranges::find(roles, meaning, &Role::meaning) - roles.begin();
    if (at < std::ssize(roles)) out.insert(out.end(), columns[at].begin(), columns[at].end());
  };
  const auto has_three = [&](Meaning meaning) {
    return std::ranges::count(roles, meaning, &Role::meaning) == 3;
  };
  append(Meaning::time, recording.time_s), append(Meaning::force_time, recording.force_time_s);
  append(Meaning::depth, recording.travel_m);
  for (const auto& [meaning, points] : {std::pair{Meaning::position, &recording.position_m},
                                        {Meaning::force, &recording.force_N},
                                        {Meaning::torque, &recording.torque_Nm}})
    if (has_three(meaning)) *points = points_of(meaning, roles, columns);
  if (!has_three(Meaning::force)) append(Meaning::force, recording.push_N);
  recording.line = std::move(line);
  return recording;
}

std::optional<Meaning> meaning_named(const std::string& name) {
  const Stem* row = stem_named(in_small_letters(name));
  return row ? std::optional(row->meaning) : std::nullopt;
}

NamedColumns columns_named(const std::vector<std::string>& header) {
  QuantityNames time, place, force, torque;
  NamedColumns out;
  const auto note = [&](const std::string& problem, const std::string& remedy) {
    if (out.problem.empty()) out.problem = problem, out.remedy = remedy;
  };
  const std::array quantities{std::pair{&place, Dimension::length},
                              std::pair{&force, Dimension::force},
                              std::pair{&time, Dimension::time}};
  std::array<std::vector<std::string>, 3> by_unit;  // names that are not known, by their brackets
  // Those that begin or end with an axis, by the rest and the unit.
  std::array<std::map<std::string, QuantityNames>, 2> by_axis;
  for (const std::string& name : header) {
    const auto [stem, unit] = stem_and_unit(name);
    const Stem* row = stem_named(stem);
    if (!row) {
      for (std::size_t k = 0; k < quantities.size(); ++k)
        if (unit_factor(split_unit(name).second, quantities[k].second)) by_unit[k].push_back(name);
      for (std::size_t k = 0; k < by_axis.size() && stem.size() > 1; ++k)
        for (const std::size_t at : {std::size_t{0}, stem.size() - 1})
          if (stem[at] >= 'x' && stem[at] <= 'z' && unit_factor(unit, quantities[k].second))
            by_axis[k][std::string(stem).replace(at, 1, "*") + " " + unit]
                .axes[stem[at] - 'x']
                .push_back(name);
      continue;
    }
    const Dimension dimension = quantity_of(row->meaning)->dimension;
    QuantityNames& found = row->meaning == Meaning::time     ? time
                           : row->meaning == Meaning::force  ? force
                           : row->meaning == Meaning::torque ? torque
                                                             : place;
    (!unit_factor(unit, dimension) ? found.odd
     : row->axis < 0               ? found.alone
                                   : found.axes[row->axis])
        .push_back(name);
  }
  const auto is_named = [](const QuantityNames& found) {
    return !found.is_empty() || !found.odd.empty();
  };
  for (std::size_t k = 0; k < quantities.size(); ++k)
    if (!is_named(*quantities[k].first) && by_unit[k].size() == 1)
      quantities[k].first->alone = by_unit[k];
  for (std::size_t k = 0; k < by_axis.size(); ++k) {
    std::erase_if(by_axis[k], [](const auto& names) { return !names.second.has_three(); });
    if (!is_named(*quantities[k].first) && by_axis[k].size() == 1)
      *quantities[k].first = by_axis[k].begin()->second;
  }
  if (!is_named(place) || !is_named(force) || (place.is_empty() && force.is_empty())) return {};
  for (const auto& [found, dimension] : quantities)
    if (found->is_empty() && !found->odd.empty())
      note("column `" + found->odd[0] + "` is in `" + stem_and_unit(found->odd[0]).second +
               "`, which is no unit of " + std::string(dimension_name(dimension)),
           "Known: " + known_units(dimension) + ". Or name the columns in the manifest.");
  // The one name of what there may be one of.
  const auto one = [&](const std::vector<std::string>& names, const std::string& quantity) {
    if (names.size() > 1)
      note("columns `" + names[0] + "` and `" + names[1] + "` may both be the " + quantity,
           "Name the columns in the manifest.");
    return names.empty() ? std::string() : names[0];
  };
  const auto three = [&](const QuantityNames& found, const std::string& quantity) {
    std::vector<std::string> names;
    for (const auto& axis : found.axes) names.push_back(one(axis, quantity));
    return names;
  };
  out.columns.time = one(time.any(), "time");
  if (force.has_three())
    out.columns.force = three(force, "force");
  else
    out.columns.force = {one(force.any(), "force")};
  if (place.has_three() && (place.alone.empty() || force.has_three()))
    out.columns.position = three(place, "position");
  else
    out.columns.depth = one(place.any(), "depth");
  if (torque.has_three()) out.columns.torque = three(torque, "torque");
  return out;
}

ReadSettings with_named_columns(const ReadSettings& settings,
                                const std::vector<std::string>& header, const FailColumn& fail,
                                std::string& taken) {
  ReadSettings out = settings;
  if (!roles_of(settings.columns).empty()) return out;
  const NamedColumns named = columns_named(header);
  if (named.columns.force.empty()) return out;
  if (!named.problem.empty()) throw fail(named.problem, named.remedy);
  if (!settings.is_force_on_tool)
    throw fail("force_on is missing: whose force the sensor reports",
               "Add force_on = \"tool\" (what the sensor feels) or \"body\" (what the body feels) "
               "to the manifest.");
  out.columns = named.columns;
  std::vector<std::string> names;
  for (const Role& role : roles_of(out.columns)) names.push_back(role.name);
  taken = "columns " + listed(names);
  return out;
}

}  // namespace palpate::importers
