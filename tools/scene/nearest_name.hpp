#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace palpate::tools {

/// The name with the fewest single-letter edits from `typed` (Levenshtein 1966), the first of
/// equals; names that begin with it come first. Empty when all are far from it: more than two edits
/// and a third of its letters.
std::string nearest_name(std::string_view typed, const std::vector<std::string_view>& names);

/// "Did you mean "depth"? Known: ...", without the question where no name is near.
std::string suggestion(std::string_view typed, const std::vector<std::string_view>& names);

/// The remedy for a name that is gone; empty for a name that never was. of: the command whose
/// option it is, the key whose value it is, "command", or "key" of a scene, a manifest or a study.
std::string remedy_of_former(std::string_view of, std::string_view name);

}  // namespace palpate::tools
