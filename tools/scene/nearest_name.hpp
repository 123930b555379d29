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

}  // namespace palpate::tools
