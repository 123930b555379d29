#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace palpate {

/// A partition of 0 .. size - 1 that grows coarser; the root of a set is its least member.
/// Source: Tarjan and van Leeuwen, Worst-case analysis of set union algorithms (1984), path
/// halving.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t size) : parent_(size) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }
  std::size_t find(std::size_t member) {
    while (parent_[member] != member) member = parent_[member] = parent_[parent_[member]];
    return member;
  }
  void join(std::size_t a, std::size_t b) {
    const auto [low, high] = std::minmax({find(a), find(b)});
    parent_[high] = low;
  }

 private:
  std::vector<std::size_t> parent_;
};

}  // namespace palpate
