#include "libfem/solve/elimination.hpp"

#include <suitesparse/cholmod.h>

#include <algorithm>
#include <mutex>
#include <new>

namespace palpate::fem {
namespace {

struct Cholmod {
  cholmod_common common;
  cholmod_factor* factor = nullptr;

  Cholmod() {
    cholmod_start(&common);
    common.print = 0;
    common.error_handler = nullptr;
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.nmethods = 1;
    common.method[0].ordering = CHOLMOD_GIVEN;
  }
  ~Cholmod() {
    cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
  }
  Cholmod(const Cholmod&) = delete;
  Cholmod& operator=(const Cholmod&) = delete;
};

/// A view of our arrays as the lower triangle of a symmetric pattern; CHOLMOD does not write to them.
cholmod_sparse pattern_view(std::size_t size, const std::vector<std::int32_t>& starts,
                            const std::vector<std::int32_t>& rows) {
  cholmod_sparse matrix{};
  matrix.nrow = matrix.ncol = size;
  matrix.nzmax = rows.size();
  matrix.p = const_cast<std::int32_t*>(starts.data());
  matrix.i = const_cast<std::int32_t*>(rows.data());
  matrix.stype = -1;
  matrix.itype = CHOLMOD_INT;
  matrix.xtype = CHOLMOD_PATTERN;
  matrix.dtype = CHOLMOD_DOUBLE;
  matrix.sorted = matrix.packed = 1;
  return matrix;
}

/// CHOLMOD post-orders what it is given. The last nodes are a chain at the top of the elimination
/// tree and so stay last, node by node, unless the body falls apart.
void settle_dense_block(const SymmetricBlockMatrix& pattern, Elimination& out) {
  const std::size_t size = out.order.size(), inner = size - 3 * out.last_nodes.size();
  std::vector<char> is_last(pattern.nodes(), 0);
  for (const std::int32_t node : out.last_nodes) is_last[node] = 1;
  bool is_kept = true;
  for (std::size_t k = inner; k < size; k += 3)
    for (int c = 0; c < 3; ++c)
      is_kept &= is_last[out.order[k + c] / 3] && out.order[k + c] == out.order[k] + c;
  out.last_nodes.clear();
  out.inner = static_cast<std::int32_t>(is_kept ? inner : size);
  for (std::size_t k = out.inner; k < size; k += 3) out.last_nodes.push_back(out.order[k] / 3);
}

}  // namespace

std::vector<std::int32_t> dissect(const SymmetricBlockMatrix& pattern) {
  Cholmod cholmod;
  std::vector<std::int32_t> order(pattern.nodes());
  if (order.empty()) return order;
  cholmod_sparse graph = pattern_view(order.size(), pattern.block_start(), pattern.block_row());
  // METIS draws from one random sequence per process, seeded at its start: one call at a time, or
  // the order (and with it the last bits of every force) depends on what other threads do.
  static std::mutex one_at_a_time;
  const std::lock_guard<std::mutex> lock(one_at_a_time);
  if (!cholmod_metis(&graph, nullptr, 0, 1, order.data(), &cholmod.common) &&
      !cholmod_amd(&graph, nullptr, 0, order.data(), &cholmod.common))
    throw std::bad_alloc();
  return order;
}

Elimination analyse_elimination(const SymmetricBlockMatrix& pattern,
                                const std::vector<std::int32_t>& node_order,
                                const std::vector<std::int32_t>& last_nodes) {
  Cholmod cholmod;
  std::vector<char> is_last(pattern.nodes(), 0);
  for (const std::int32_t node : last_nodes) is_last[node] = 1;
  std::vector<std::int32_t> unknowns;
  for (const bool last : {false, true})
    for (const std::int32_t node : node_order)
      for (int c = 0; c < 3 && is_last[node] == last; ++c) unknowns.push_back(3 * node + c);
  cholmod_sparse matrix =
      pattern_view(unknowns.size(), pattern.column_start(), pattern.row_index());
  cholmod.factor = cholmod_analyze_p(&matrix, unknowns.data(), nullptr, 0, &cholmod.common);
  if (!cholmod.factor) throw std::bad_alloc();

  Elimination out;
  out.last_nodes = last_nodes;
  out.flops = cholmod.common.fl;
  const auto* perm = static_cast<const std::int32_t*>(cholmod.factor->Perm);
  out.order.assign(perm, perm + cholmod.factor->n);
  settle_dense_block(pattern, out);
  const auto* super = static_cast<const std::int32_t*>(cholmod.factor->super);
  const auto* row_start = static_cast<const std::int32_t*>(cholmod.factor->pi);
  const auto* rows = static_cast<const std::int32_t*>(cholmod.factor->s);
  out.row_start.push_back(0);
  for (std::size_t s = 0; s < cholmod.factor->nsuper && super[s] < out.inner; ++s) {
    out.first.push_back(super[s]);
    out.rows.insert(out.rows.end(), rows + row_start[s], rows + row_start[s + 1]);
    out.row_start.push_back(static_cast<std::int32_t>(out.rows.size()));
  }
  out.first.push_back(out.inner);
  return out;
}

}  // namespace palpate::fem
