#include "libfem/solve/factor/schur_factor.hpp"

#include <fmt/core.h>
#include <suitesparse/cholmod.h>
#include <algorithm>
#include <atomic>
#include <mutex>
#include <new>

#include "libfem/solve/factor/dense_kernels.hpp"
#include "libfit/core/error.hpp"

namespace palpate::fem {
namespace {

std::atomic<double> max_bytes = 2e9;

void check_memory(const Elimination& plan) {
  const double bytes = elimination_bytes(plan);
  if (bytes <= max_bytes) return;
  throw Error("the mesh of an experiment",
              fmt::format("has {} nodes, and its factor takes {:.2g} GB of the {:.2g} GB that are "
                          "allowed",
                          plan.order.size(), bytes / 1e9, max_bytes / 1e9),
              fmt::format("Set a larger mesh_size in [body], leave parts far from the region out "
                          "of the surface, or allow it: memory_GB = {:.2g} in [experiments].",
                          1.1 * bytes / 1e9));
}

/// Lower factor; false when `matrix` is not positive definite.
bool factor_dense(const Eigen::MatrixXd& matrix, Eigen::MatrixXf& out) {
  const int size = static_cast<int>(matrix.rows());
  out = matrix.cast<float>();
  return dense_kernels().factor_front(out.data(), size, size);
}

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

void bound_factor_memory(double bytes) { max_bytes = bytes; }

void SchurFactor::analyse(const SymmetricBlockMatrix& K,
                          const std::vector<std::int32_t>& contact_nodes) {
  if (node_order_.empty()) node_order_ = dissect(K);
  plan_ = analyse_elimination(K, node_order_, contact_nodes);
  check_memory(plan_);
  x_.resize(K.size());
  std::size_t most = 0;
  for (int s = 0; s < plan_.supernodes(); ++s)
    most = std::max(
        most, panel_work_size(3 * plan_.columns(s), 3 * (plan_.height(s) - plan_.columns(s))));
  work_.resize(most);
}

bool SchurFactor::eliminate_and_invert(const SymmetricBlockMatrix& K) {
  if (needs_double_ || !eliminate(plan_, K, room_, frontal_)) {
    if (!eliminate(plan_, K, double_room_, frontal_)) return false;
    needs_double_ = true;
  }
  // Without the probe the body may not be stable: springs then stand in for it.
  Eigen::MatrixXd held = frontal_.schur;
  for (double springs = 0.03; !factor_dense(held, flexibility_); springs *= 10) {
    // Springs beyond a million times the largest stiffness of a contact node do not help:
    if (!(springs < 1e6)) return false;  // something is not a number
    held.diagonal().array() += springs * frontal_.schur.diagonal().cwiseAbs().maxCoeff();
  }
  dense_kernels().invert_from_factor(flexibility_.data(), static_cast<int>(flexibility_.rows()));
  return true;
}

PanelTask SchurFactor::task_of(int s) {
  return {frontal_.panels.data() + frontal_.panel_start[s],
          3 * plan_.columns(s),
          3 * (plan_.height(s) - plan_.columns(s)),
          plan_.rows.data() + plan_.row_start[s] + plan_.columns(s),
          x_.data(),
          x_.data() + std::ptrdiff_t{3} * plan_.first[s],
          work_.data()};
}

bool SchurFactor::factor(const SymmetricBlockMatrix& K,
                         const std::vector<std::int32_t>& contact_nodes) {
  std::vector<std::int32_t> own = plan_.last_nodes, wanted = contact_nodes;
  std::sort(own.begin(), own.end());
  std::sort(wanted.begin(), wanted.end());
  if (plan_.order.empty() || own != wanted) analyse(K, wanted);
  is_factored_ = eliminate_and_invert(K);
  return is_factored_;
}

bool SchurFactor::is_stable_with(const Eigen::MatrixXd& C) const {
  Eigen::MatrixXf unused;
  return factor_dense(frontal_.schur + C, unused);
}

void SchurFactor::solve(const Eigen::VectorXd& b, Eigen::VectorXd& x) {
  Eigen::VectorXd load;
  reduce(b, load);
  expand((flexibility_ * load.cast<float>()).cast<double>(), x);
}

void SchurFactor::reduce(const Eigen::VectorXd& b, Eigen::VectorXd& reduced) {
  for (std::size_t k = 0; k < plan_.order.size(); ++k)
    x_.segment<3>(3 * k) = b.segment<3>(3 * plan_.order[k]).cast<float>();
  for (int s = 0; s < plan_.supernodes(); ++s) kernels_.forward(task_of(s));
  reduced = x_.tail(frontal_.schur.rows()).cast<double>();
}

void SchurFactor::expand(const Eigen::VectorXd& contact_displacement, Eigen::VectorXd& x) {
  x_.tail(contact_displacement.size()) = contact_displacement.cast<float>();
  for (int s = plan_.supernodes() - 1; s >= 0; --s) kernels_.backward(task_of(s));
  x.resize(x_.size());
  for (std::size_t k = 0; k < plan_.order.size(); ++k)
    x.segment<3>(3 * plan_.order[k]) = x_.segment<3>(3 * k).cast<double>();
  // Stiff contact would amplify the rounding of its own displacement, which is kept exact.
  for (std::size_t i = 0; i < contact_nodes().size(); ++i)
    x.segment<3>(3 * contact_nodes()[i]) = contact_displacement.segment<3>(3 * i);
}

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
  // CHOLMOD post-orders what it is given. The last nodes are a chain at the top of the elimination
  // tree and so stay last, unless the body falls apart; then there is no dense block.
  out.inner = static_cast<std::int32_t>(out.order.size() - last_nodes.size());
  for (std::size_t k = out.inner; k < out.order.size(); ++k)
    if (!is_last[out.order[k]]) out.inner = static_cast<std::int32_t>(out.order.size());
  out.last_nodes.assign(out.order.begin() + out.inner, out.order.end());
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
