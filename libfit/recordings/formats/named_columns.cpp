// Columns that say in their name what they are: quantity and unit.

#include <algorithm>
#include <array>

#include "libfit/core/text.hpp"
#include "libfit/recordings/formats/columns.hpp"

namespace palpate::importers {
namespace {

// The names of a quantity, in small letters; the first that a header has is taken.
struct Stem {
  Meaning meaning;
  int axis;                ///< -1: of one axis alone
  std::string_view names;  ///< with blanks between; English, German, French, Spanish, Italian
};
constexpr auto kStems = std::to_array<Stem>({
    {Meaning::time, -1, "t time zeit temps tiempo tempo"},
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
