#include "libfem/solve/factor/schur_factor.hpp"

#include <algorithm>

#include "libfem/solve/factor/dense_kernels.hpp"

namespace palpate::fem {
namespace {

/// A square column-major matrix over some places; the lower triangle counts.
template <class Real>
struct Front {
  Real* values;
  std::size_t size;                           // unknowns
  const std::vector<std::int32_t>* position;  // of a place among its nodes
};

template <class Real>
Front<Real> empty_front(Real* room, std::size_t size, const std::vector<std::int32_t>& position) {
  for (std::size_t c = 0; c < size; ++c)
    std::fill(room + size * c + c, room + size * (c + 1), Real{0});
  return {room, size, &position};
}

/// Adds the block (row node, column node) of K to a front.
template <class Real>
void add_block(const SymmetricBlockMatrix& K, std::int32_t node, std::int32_t b,
               const Elimination& plan, const Front<Real>& front) {
  const std::int32_t base = K.column_start()[3 * node] + 3 * (b - K.block_start()[node]);
  const std::int32_t length = K.column_start()[3 * node + 1] - K.column_start()[3 * node];
  const double* first = K.values().data() + base;
  const double* column[3] = {first, first + length - 1, first + 2 * length - 3};
  const std::int32_t j = plan.place[node], i = plan.place[K.block_row()[b]];
  const bool is_swapped = i < j;
  const std::size_t row = 3 * (*front.position)[std::max(i, j)],
                    col = 3 * (*front.position)[std::min(i, j)];
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t r = i == j ? c : 0; r < 3; ++r) {
      const std::size_t at =
          is_swapped ? front.size * (col + r) + row + c : front.size * (col + c) + row + r;
      front.values[at] += static_cast<Real>(column[c][r]);
    }
}

/// Adds what a supernode leaves (lower triangle over `count` places) to a front.
template <class Real>
void extend_add(const Real* update, const std::int32_t* places, int count,
                const Front<Real>& front) {
  const std::size_t n = 3 * static_cast<std::size_t>(count);
  for (int j = 0; j < count; ++j) {
    const std::size_t col = 3 * (*front.position)[places[j]];
    for (std::size_t c = 0; c < 3; ++c) {
      const Real* from = update + n * (3 * j + c);
      Real* to = front.values + front.size * (col + c);
      for (std::size_t r = c; r < 3; ++r) to[col + r] += from[3 * j + r];
      for (int i = j + 1; i < count; ++i) {
        Real* block = to + 3 * (*front.position)[places[i]];
        for (std::size_t r = 0; r < 3; ++r) block[r] += from[3 * i + r];
      }
    }
  }
}

/// Beginning of each supernode's panel, and the end.
auto panel_starts(const Elimination& plan) {
  decltype(FrontalFactor::panel_start) out{0};
  for (int s = 0; s < plan.supernodes(); ++s)
    out.push_back(out.back() +
                  panel_size(3 * plan.columns(s), 3 * (plan.height(s) - plan.columns(s))));
  return out;
}

/// Numbers that a supernode leaves to its parent.
std::size_t left_by(const Elimination& plan, int s) {
  const std::size_t under = 3 * static_cast<std::size_t>(plan.height(s) - plan.columns(s));
  return under * under;
}

/// Numbers in the largest front, and the most that is left to supernodes above at any time.
struct RoomSize {
  std::size_t front = 0, left = 0;
};

RoomSize room_of(const Elimination& plan) {
  RoomSize out;
  std::size_t left = 0;
  std::vector<int> waiting;
  for (int s = 0; s < plan.supernodes(); ++s) {
    const std::size_t size = 3 * static_cast<std::size_t>(plan.height(s));
    out.front = std::max(out.front, size * size);
    for (; !waiting.empty() && plan.parent[waiting.back()] == s; waiting.pop_back())
      left -= left_by(plan, waiting.back());
    out.left = std::max(out.left, left + left_by(plan, s));
    if (plan.parent[s] < 0) continue;
    left += left_by(plan, s);
    waiting.push_back(s);
  }
  return out;
}

/// The blocks of K by the place at which they are taken up: node and index of each.
struct BlockList {
  std::vector<std::int32_t> start, node, block;
};

BlockList blocks_by_place(const SymmetricBlockMatrix& K, const Elimination& plan) {
  BlockList out;
  out.start.assign(plan.order.size() + 1, 0);
  const auto visit = [&](const auto& act) {
    for (std::int32_t j = 0; j < K.nodes(); ++j)
      for (std::int32_t b = K.block_start()[j]; b < K.block_start()[j + 1]; ++b)
        act(std::min(plan.place[j], plan.place[K.block_row()[b]]), j, b);
  };
  visit([&](std::int32_t at, std::int32_t, std::int32_t) { ++out.start[at + 1]; });
  for (std::size_t k = 0; k < plan.order.size(); ++k) out.start[k + 1] += out.start[k];
  out.node.resize(out.start.back());
  out.block.resize(out.start.back());
  std::vector<std::int32_t> next(out.start.begin(), out.start.end() - 1);
  visit([&](std::int32_t at, std::int32_t node, std::int32_t b) {
    out.node[next[at]] = node;
    out.block[next[at]++] = b;
  });
  return out;
}

}  // namespace

double elimination_bytes(const Elimination& plan) {
  // The dense block in single and in double precision, and its inverse.
  const std::size_t dense = 3 * plan.last_nodes.size();
  const RoomSize room = room_of(plan);
  const double numbers = static_cast<double>(panel_starts(plan).back() + room.front + room.left) +
                         4.0 * static_cast<double>(dense * dense);
  return sizeof(float) * numbers;
}

template <class Real>
bool eliminate(const Elimination& plan, const SymmetricBlockMatrix& K, EliminationRoom<Real>& room,
               FrontalFactor& out) {
  using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
  const auto factor_front = [] {
    if constexpr (std::is_same_v<Real, float>)
      return dense_kernels().factor_front;
    else
      return dense_kernels().factor_front_double;
  }();
  const BlockList blocks = blocks_by_place(K, plan);
  std::vector<std::int32_t> position(plan.order.size());
  const int dense = 3 * static_cast<int>(plan.last_nodes.size());
  Matrix schur = Matrix::Zero(dense, dense);
  std::vector<std::int32_t> in_schur(plan.order.size(), -1);
  for (std::size_t k = plan.inner; k < plan.order.size(); ++k)
    in_schur[k] = static_cast<std::int32_t>(k) - plan.inner;
  const Front<Real> last{schur.data(), static_cast<std::size_t>(dense), &in_schur};
  const auto take_up = [&](std::int32_t place, const Front<Real>& front) {
    for (std::int32_t e = blocks.start[place]; e < blocks.start[place + 1]; ++e)
      add_block(K, blocks.node[e], blocks.block[e], plan, front);
  };

  out.panel_start = panel_starts(plan);
  out.panels.resize(out.panel_start.back() + kPanelPadding);
  // What supernodes leave waits on a stack for their parent: a post-order finds its children on
  // top.
  const RoomSize size = room_of(plan);
  Real *const work = room.front.at_least(size.front), *const stack = room.left.at_least(size.left);
  std::size_t end = 0;                               // of the stack
  std::vector<std::pair<int, std::size_t>> waiting;  // supernode, begin on the stack
  for (int s = 0; s < plan.supernodes(); ++s) {
    const std::int32_t* rows = plan.rows.data() + plan.row_start[s];
    const int own = 3 * plan.columns(s), n = 3 * plan.height(s), under = n - own;
    for (int r = 0; r < plan.height(s); ++r) position[rows[r]] = r;
    const Front<Real> front = empty_front(work, static_cast<std::size_t>(n), position);
    for (int c = 0; c < plan.columns(s); ++c) take_up(rows[c], front);
    while (!waiting.empty() && plan.parent[waiting.back().first] == s) {
      const auto [child, begin] = waiting.back();
      extend_add(stack + begin, plan.rows.data() + plan.row_start[child] + plan.columns(child),
                 plan.height(child) - plan.columns(child), front);
      end = begin;
      waiting.pop_back();
    }
    if (!factor_front(work, n, own)) return false;
    float* panel = out.panels.data() + out.panel_start[s];
    if (under > 0) {
      const Real* tail = work + std::size_t(n) * own + own;
      const std::size_t u = static_cast<std::size_t>(under);
      Real* const left = stack + end;
      for (std::size_t j = 0; j < u; ++j)
        std::copy(tail + n * j + j, tail + n * j + u, left + u * j + j);
      if (plan.parent[s] >= 0) {
        waiting.emplace_back(s, end);
        end += u * u;
      } else {
        extend_add(left, rows + plan.columns(s), under / 3, last);
      }
    }
    pack_panel(work, own, under, panel);
  }
  for (std::size_t k = plan.inner; k < plan.order.size(); ++k)
    take_up(static_cast<std::int32_t>(k), last);
  out.schur = schur.template cast<double>();
  out.schur.template triangularView<Eigen::StrictlyUpper>() = out.schur.transpose();
  return true;
}

template bool eliminate<float>(const Elimination&, const SymmetricBlockMatrix&,
                               EliminationRoom<float>&, FrontalFactor&);
template bool eliminate<double>(const Elimination&, const SymmetricBlockMatrix&,
                                EliminationRoom<double>&, FrontalFactor&);

}  // namespace palpate::fem
