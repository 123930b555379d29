// Columns that say in their name what they are: quantity and unit.

#include <algorithm>
#include <array>

#include "libfit/core/text.hpp"
#include "libfit/recordings/formats/columns.hpp"

namespace palpate::importers {
namespace {

// The names of a quantity, in small letters; the first that a header has is taken.
struct Stem {
  std::string_view name;
  Meaning meaning;
  int axis;  // -1: of one axis alone
};
constexpr auto kStems = std::to_array<Stem>({
    {"t", Meaning::time, -1},
    {"time", Meaning::time, -1},
    {"depth", Meaning::depth, -1},
    {"indentation", Meaning::depth, -1},
    {"travel", Meaning::depth, -1},
    {"displacement", Meaning::depth, -1},
    {"compression", Meaning::depth, -1},
    {"d", Meaning::depth, -1},
    {"x", Meaning::position, 0},
    {"y", Meaning::position, 1},
    {"z", Meaning::position, 2},
    {"px", Meaning::position, 0},
    {"py", Meaning::position, 1},
    {"pz", Meaning::position, 2},
    {"pos_x", Meaning::position, 0},
    {"pos_y", Meaning::position, 1},
    {"pos_z", Meaning::position, 2},
    {"position_x", Meaning::position, 0},
    {"position_y", Meaning::position, 1},
    {"position_z", Meaning::position, 2},
    {"tip_x", Meaning::position, 0},
    {"tip_y", Meaning::position, 1},
    {"tip_z", Meaning::position, 2},
    {"f", Meaning::force, -1},
    {"force", Meaning::force, -1},
    {"load", Meaning::force, -1},
    {"push", Meaning::force, -1},
    {"normal_force", Meaning::force, -1},
    {"fx", Meaning::force, 0},
    {"fy", Meaning::force, 1},
    {"fz", Meaning::force, 2},
    {"f_x", Meaning::force, 0},
    {"f_y", Meaning::force, 1},
    {"f_z", Meaning::force, 2},
    {"force_x", Meaning::force, 0},
    {"force_y", Meaning::force, 1},
    {"force_z", Meaning::force, 2},
    {"tx", Meaning::torque, 0},
    {"ty", Meaning::torque, 1},
    {"tz", Meaning::torque, 2},
    {"torque_x", Meaning::torque, 0},
    {"torque_y", Meaning::torque, 1},
    {"torque_z", Meaning::torque, 2},
    {"mx", Meaning::torque, 0},
    {"my", Meaning::torque, 1},
    {"mz", Meaning::torque, 2},
    // German, French, Spanish, Italian
    {"zeit", Meaning::time, -1},
    {"temps", Meaning::time, -1},
    {"tiempo", Meaning::time, -1},
    {"tempo", Meaning::time, -1},
    {"weg", Meaning::depth, -1},
    {"tiefe", Meaning::depth, -1},
    {"eindringtiefe", Meaning::depth, -1},
    {"verfahrweg", Meaning::depth, -1},
    {"profondeur", Meaning::depth, -1},
    {"d\xC3\xA9placement", Meaning::depth, -1},
    {"deplacement", Meaning::depth, -1},
    {"enfoncement", Meaning::depth, -1},
    {"profundidad", Meaning::depth, -1},
    {"desplazamiento", Meaning::depth, -1},
    {"profondit\xC3\xA0", Meaning::depth, -1},
    {"profondita", Meaning::depth, -1},
    {"spostamento", Meaning::depth, -1},
    {"kraft", Meaning::force, -1},
    {"normalkraft", Meaning::force, -1},
    {"last", Meaning::force, -1},
    {"effort", Meaning::force, -1},
    {"charge", Meaning::force, -1},
    {"fuerza", Meaning::force, -1},
    {"carga", Meaning::force, -1},
    {"forza", Meaning::force, -1},
    {"carico", Meaning::force, -1},
});

Dimension dimension_of(Meaning meaning) {
  return meaning == Meaning::time     ? Dimension::time
         : meaning == Meaning::force  ? Dimension::force
         : meaning == Meaning::torque ? Dimension::torque
                                      : Dimension::length;
}

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
  const auto row = std::ranges::find(kStems, stem, &Stem::name);
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
  for (const std::string& name : header) {
    const auto [stem, unit] = stem_and_unit(name);
    const Stem* row = stem_named(stem);
    if (!row) continue;
    const Dimension dimension = dimension_of(row->meaning);
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
  if (!is_named(place) || !is_named(force) || (place.is_empty() && force.is_empty())) return {};
  for (const auto& [found, dimension] :
       {std::pair{&place, Dimension::length}, {&force, Dimension::force}, {&time, Dimension::time}})
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
