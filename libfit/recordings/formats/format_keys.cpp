#include "libfit/recordings/formats/format_keys.hpp"

#include <algorithm>
#include <array>

namespace palpate::importers {
namespace {

constexpr std::string_view kNamedTables = "csv hdf5 matlab", kDelimited = "csv robot-palpation",
                           kRobot = "robot-palpation",
                           kByItself = "Leave it out: a file of this format says it itself.",
                           kOfRobots = "Leave it out: it is of the format robot-palpation.",
                           kOfText = "Leave it out: it is of delimited text.";

constexpr std::array kKeys{
    FormatKey{"columns.depth", kNamedTables, "Name columns.position."},
    FormatKey{"columns.retract_depth", kNamedTables, kByItself},
    FormatKey{"columns.retract_force", kNamedTables, kByItself},
    FormatKey{"columns.force_time", kNamedTables, kByItself},
    FormatKey{"columns.contact", kRobot, kOfRobots},
    FormatKey{"columns.normal", kRobot, kOfRobots},
    FormatKey{"normals", kRobot, "Leave it out, and turn `normal` around where it is outward."},
    FormatKey{"separator", kDelimited, kOfText},
    FormatKey{"decimal", kDelimited, kOfText},
    FormatKey{"comment", kDelimited, kOfText},
    FormatKey{"encoding", kDelimited, kOfText},
};

}  // namespace

std::span<const FormatKey> format_keys() { return kKeys; }

const FormatKey* format_key(std::string_view name) {
  const auto row = std::ranges::find(kKeys, name, &FormatKey::name);
  return row == kKeys.end() ? nullptr : &*row;
}

bool is_read_by(const FormatKey& key, std::string_view format) {
  for (std::string_view rest = key.formats; !rest.empty();) {
    const std::size_t end = std::min(rest.find(' '), rest.size());
    if (rest.substr(0, end) == format) return true;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return false;
}

}  // namespace palpate::importers
