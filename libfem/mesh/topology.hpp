#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "libfit/core/geometry.hpp"

namespace palpate {

/// Corners of a triangle.
using Triangle = std::array<std::int32_t, 3>;

/// A list of points, or of the corners of cells, as the rows of a matrix; a view.
template <class Row>
auto rows_of(const std::vector<Row>& list) {
  using Scalar = typename Row::value_type;
  constexpr int kWidth = sizeof(Row) / sizeof(Scalar);
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, kWidth, Eigen::RowMajor>;
  return Eigen::Map<const Matrix>(reinterpret_cast<const Scalar*>(list.data()), list.size(),
                                  kWidth);
}

/// Sorts and keeps one of each.
template <class List>
void sort_unique(List& list) {
  std::ranges::sort(list);
  list.erase(std::ranges::unique(list).begin(), list.end());
}

/// Flags cells that have the corners of an earlier one, in whatever order.
template <class Cell>
std::vector<char> repeats(std::vector<Cell> cells) {
  std::vector<std::pair<Cell, std::size_t>> sorted(cells.size());
  for (std::size_t c = 0; c < cells.size(); ++c) {
    std::ranges::sort(cells[c]);
    sorted[c] = {cells[c], c};
  }
  std::ranges::sort(sorted);
  std::vector<char> is_repeat(cells.size(), 0);
  for (std::size_t i = 1; i < sorted.size(); ++i)
    is_repeat[sorted[i].second] = sorted[i].first == sorted[i - 1].first;
  return is_repeat;
}

/// Renumbers the corners of cells without gaps and returns the old number of each new one: in the
/// order of first use, or ascending. corners: below `count`.
enum class Numbering { by_use, ascending };
std::vector<std::int32_t> renumber(std::span<std::int32_t> corners, std::size_t count,
                                   Numbering numbering);

/// A triangle's side from corner `corner` to the next, as its edge low-high.
struct TriangleSide {
  std::int32_t low, high;
  std::int32_t face;
  std::int8_t corner;
  bool is_forward;  ///< the triangle runs from low to high
};

/// All sides, those of one edge together; within an edge by face.
std::vector<TriangleSide> sorted_sides(const Eigen::Ref<const Triangles>& triangles);

/// Calls use(begin, end) with the sides of each edge of `sides`, which sorted_sides made.
template <typename Use>
void for_each_edge(const std::vector<TriangleSide>& sides, Use use) {
  for (auto begin = sides.begin(); begin != sides.end();) {
    auto end = begin + 1;
    while (end != sides.end() && end->low == begin->low && end->high == begin->high) ++end;
    use(begin, end);
    begin = end;
  }
}

/// Component of each face, numbered from 0 in the order of faces; faces that share an edge belong
/// together.
struct Components {
  std::vector<std::size_t> of_face;
  std::size_t number = 0;
};
Components components(const Eigen::Ref<const Triangles>& triangles);

/// Joins the corners (3 f + k) of two triangles at both ends of the edge that these sides share.
void join_fans(const Eigen::Ref<const Triangles>& triangles, const TriangleSide& a,
               const TriangleSide& b, DisjointSets& corners);

/// Sets of the corners of triangles, 3 f + k each: those at one vertex whose triangles share an
/// edge there, one after another, are one set, a fan.
DisjointSets corner_fans(const Eigen::Ref<const Triangles>& triangles);

/// Cells around each of `count` vertices, ascending.
template <class Cells>
std::vector<std::vector<std::int32_t>> cells_around(const Cells& cells, std::size_t count) {
  std::vector<std::vector<std::int32_t>> around(count);
  for (std::int32_t c = 0; c < cells.rows(); ++c)
    for (const std::int32_t v : cells.row(c)) around[v].push_back(c);
  return around;
}

/// Vertices below `count` whose triangles fall into several fans that share no edge there;
/// ascending.
std::vector<std::int32_t> pinched_vertices(const Eigen::Ref<const Triangles>& triangles,
                                           std::size_t count);

}  // namespace palpate
