#pragma once

#include <cstdint>
#include <vector>

#include "libfit/runtime/asset/format.hpp"

namespace palpate {

/// A bounding tree in the preorder of libfit/runtime/asset/format.hpp.
struct Tree {
  std::vector<runtime::TreeNode> nodes;
  std::vector<std::int32_t> items;
};

/// Tree over the given triangles, split at the median centre along the longest side, so its depth
/// is log2 of the count. vertex V x 3 [m], triangle F x 3, items at least one. Deterministic.
Tree make_tree(const std::vector<float>& vertex, const std::vector<std::int32_t>& triangle,
               std::vector<std::int32_t> items);

}  // namespace palpate
