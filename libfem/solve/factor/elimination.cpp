#include "libfem/solve/factor/multifrontal.hpp"

#include <suitesparse/cholmod.h>

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
    // Supernodes of so few columns are merged with their parents whatever zeros that stores;
    // CHOLMOD's own numbers, over the three unknowns of a node.
    common.nrelax[0] = 2;
    common.nrelax[1] = 6;
    common.nrelax[2] = 16;
  }
  ~Cholmod() {
    cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
  }
  Cholmod(const Cholmod&) = delete;
  Cholmod& operator=(const Cholmod&) = delete;
};

/// A view of the graph of nodes; CHOLMOD does not write to it.
cholmod_sparse graph_of(const SymmetricBlockMatrix& pattern) {
  cholmod_sparse graph{};
  graph.nrow = graph.ncol = static_cast<std::size_t>(pattern.nodes());
  graph.nzmax = pattern.block_row().size();
  graph.p = const_cast<std::int32_t*>(pattern.block_start().data());
  graph.i = const_cast<std::int32_t*>(pattern.block_row().data());
  graph.stype = -1;
  graph.itype = CHOLMOD_INT;
  graph.xtype = CHOLMOD_PATTERN;
  graph.dtype = CHOLMOD_DOUBLE;
  graph.sorted = graph.packed = 1;
  return graph;
}

/// CHOLMOD post-orders what it is given. The last nodes are a chain at the top of the elimination
/// tree and so stay last, unless the body falls apart; then there is no dense block.
void settle_dense_block(std::size_t count, const std::vector<char>& is_last, Elimination& out) {
  out.inner = static_cast<std::int32_t>(out.order.size() - count);
  for (std::size_t k = out.inner; k < out.order.size(); ++k)
    if (!is_last[out.order[k]]) out.inner = static_cast<std::int32_t>(out.order.size());
  out.last_nodes.assign(out.order.begin() + out.inner, out.order.end());
}

void find_parents(Elimination& out) {
  std::vector<std::int32_t> owner(out.order.size(), -1);
  for (int s = 0; s < out.supernodes(); ++s)
    for (std::int32_t k = out.first[s]; k < out.first[s + 1]; ++k) owner[k] = s;
  for (int s = 0; s < out.supernodes(); ++s) {
    const int under = out.height(s) - out.columns(s);
    out.parent.push_back(under > 0 ? owner[out.rows[out.row_start[s] + out.columns(s)]] : -1);
  }
}

}  // namespace

std::vector<std::int32_t> dissect(const SymmetricBlockMatrix& pattern) {
  Cholmod cholmod;
  std::vector<std::int32_t> order(pattern.nodes());
  if (order.empty()) return order;
  cholmod_sparse graph = graph_of(pattern);
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
  std::vector<std::int32_t> wanted;
  for (const bool last : {false, true})
    for (const std::int32_t node : node_order)
      if (static_cast<bool>(is_last[node]) == last) wanted.push_back(node);
  cholmod_sparse graph = graph_of(pattern);
  cholmod.factor = cholmod_analyze_p(&graph, wanted.data(), nullptr, 0, &cholmod.common);
  if (!cholmod.factor) throw std::bad_alloc();

  Elimination out;
  const auto* perm = static_cast<const std::int32_t*>(cholmod.factor->Perm);
  out.order.assign(perm, perm + cholmod.factor->n);
  out.place.resize(out.order.size());
  for (std::size_t k = 0; k < out.order.size(); ++k)
    out.place[out.order[k]] = static_cast<std::int32_t>(k);
  settle_dense_block(last_nodes.size(), is_last, out);
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
  find_parents(out);
  return out;
}

}  // namespace palpate::fem
