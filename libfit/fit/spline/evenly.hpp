#pragma once

#include <vector>

namespace palpate::fit {

/// At most `most` of the values, evenly taken in their order.
template <class T>
std::vector<T> evenly(const std::vector<T>& all, std::size_t most) {
  if (all.size() <= most) return all;
  std::vector<T> some;
  for (std::size_t i = 0; i < most; ++i) some.push_back(all[i * all.size() / most]);
  return some;
}

}  // namespace palpate::fit
