#include "tools/scene/nearest_name.hpp"

#include <algorithm>
#include <numeric>

namespace palpate::tools {
namespace {

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, diagonal + (a[i - 1] == b[j - 1] ? 0 : 1)});
      diagonal = above;
    }
  }
  return row[b.size()];
}

}  // namespace

std::string nearest_name(std::string_view typed, const std::vector<std::string_view>& names) {
  const auto best = std::min_element(names.begin(), names.end(), [&](auto a, auto b) {
    return edit_distance(typed, a) < edit_distance(typed, b);
  });
  return best == names.end() ? std::string() : std::string(*best);
}

}  // namespace palpate::tools
