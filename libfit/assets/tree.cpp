#include "libfit/assets/tree.hpp"

#include <algorithm>
#include <array>

namespace palpate {
namespace {

constexpr std::ptrdiff_t kLeafTriangles = 4;  // the engine allows 8

class TreeBuilder {
 public:
  TreeBuilder(const std::vector<float>& vertex, const std::vector<std::int32_t>& triangle,
              std::vector<std::int32_t> items)
      : vertex_(vertex), triangle_(triangle) {
    tree_.items = std::move(items);
    add(0, static_cast<std::ptrdiff_t>(tree_.items.size()));
  }
  Tree take() { return std::move(tree_); }

 private:
  float coordinate(std::int32_t t, std::size_t corner, std::size_t axis) const {
    const auto v = static_cast<std::size_t>(triangle_[3 * static_cast<std::size_t>(t) + corner]);
    return vertex_[3 * v + axis];
  }
  float centre(std::int32_t t, std::size_t axis) const {  // times three
    return coordinate(t, 0, axis) + coordinate(t, 1, axis) + coordinate(t, 2, axis);
  }

  runtime::TreeNode box(std::ptrdiff_t begin, std::ptrdiff_t end) const {
    runtime::TreeNode node{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      node.lo[axis] = node.hi[axis] =
          coordinate(tree_.items[static_cast<std::size_t>(begin)], 0, axis);
      for (std::ptrdiff_t i = begin; i < end; ++i)
        for (std::size_t corner = 0; corner < 3; ++corner) {
          const float x = coordinate(tree_.items[static_cast<std::size_t>(i)], corner, axis);
          node.lo[axis] = std::min(node.lo[axis], x);
          node.hi[axis] = std::max(node.hi[axis], x);
        }
    }
    return node;
  }

  void add(std::ptrdiff_t begin, std::ptrdiff_t end) {
    const std::size_t at = tree_.nodes.size();
    tree_.nodes.push_back(box(begin, end));
    if (end - begin <= kLeafTriangles) {
      tree_.nodes[at].at = static_cast<std::int32_t>(begin);
      tree_.nodes[at].items = static_cast<std::int32_t>(end - begin);
      return;
    }
    const std::ptrdiff_t middle = begin + (end - begin) / 2;
    const std::size_t axis = longest_axis(tree_.nodes[at]);
    std::nth_element(tree_.items.begin() + begin, tree_.items.begin() + middle,
                     tree_.items.begin() + end, [&](std::int32_t s, std::int32_t t) {
                       const float a = centre(s, axis), b = centre(t, axis);
                       return a < b || (!(b < a) && s < t);
                     });
    add(begin, middle);
    tree_.nodes[at].at = static_cast<std::int32_t>(tree_.nodes.size());
    add(middle, end);
  }

  static std::size_t longest_axis(const runtime::TreeNode& node) {
    std::size_t longest = 0;
    for (std::size_t axis = 1; axis < 3; ++axis)
      if (node.hi[axis] - node.lo[axis] > node.hi[longest] - node.lo[longest]) longest = axis;
    return longest;
  }

  const std::vector<float>& vertex_;
  const std::vector<std::int32_t>& triangle_;
  Tree tree_;
};

}  // namespace

Tree make_tree(const std::vector<float>& vertex, const std::vector<std::int32_t>& triangle,
               std::vector<std::int32_t> items) {
  return TreeBuilder(vertex, triangle, std::move(items)).take();
}

}  // namespace palpate
