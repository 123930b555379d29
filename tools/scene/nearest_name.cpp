#include "tools/scene/nearest_name.hpp"

#include <fmt/format.h>

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
  const auto distance = [&](std::string_view name) {
    return typed.size() >= 3 && name.starts_with(typed) ? 1 : edit_distance(typed, name);
  };
  const auto best = std::min_element(names.begin(), names.end(),
                                     [&](auto a, auto b) { return distance(a) < distance(b); });
  const bool is_near =
      best != names.end() && distance(*best) <= std::max<std::size_t>(2, typed.size() / 3);
  return is_near ? std::string(*best) : std::string();
}

std::string suggestion(std::string_view typed, const std::vector<std::string_view>& names) {
  const std::string nearest = nearest_name(typed, names);
  return (nearest.empty() ? "" : fmt::format("Did you mean \"{}\"? ", nearest)) +
         fmt::format("Known: {}.", fmt::join(names, ", "));
}

}  // namespace palpate::tools
