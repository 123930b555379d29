#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace palpate::tools {

/// The name with the fewest single-letter edits from `typed` (Levenshtein 1966), the first of
/// equals; empty when there are no names. For "did you mean".
std::string nearest_name(std::string_view typed, const std::vector<std::string_view>& names);

}  // namespace palpate::tools
