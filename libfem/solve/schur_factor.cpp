#include "libfem/solve/schur_factor.hpp"

#include <suitesparse/cholmod.h>

#include <algorithm>
#include <mutex>
#include <new>

extern "C" {
// Present when the BLAS is OpenBLAS and when CHOLMOD was built with OpenMP; other builds of either
// need no such call.
void openblas_set_num_threads(int) __attribute__((weak));
void omp_set_max_active_levels(int) __attribute__((weak));
// BLAS and LAPACK, Fortran interface.
void dsyrk_(const char* uplo, const char* trans, const int* n, const int* k, const double* alpha,
            const double* a, const int* lda, const double* beta, double* c, const int* ldc);
void spotrf_(const char* uplo, const int* n, float* a, const int* lda, int* info);
void spotrs_(const char* uplo, const int* n, const int* right_sides, const float* a, const int* lda,
             float* b, const int* ldb, int* info);
}

namespace palpate::fem {
namespace {

void use_one_thread() {
  if (openblas_set_num_threads) openblas_set_num_threads(1);
  if (omp_set_max_active_levels) omp_set_max_active_levels(0);
}

/// A dense part of the factor: columns first .. first + columns, their own triangle on top of the
/// rows below, column major.
struct Panel {
  std::int32_t first, columns, rows;
  std::size_t entries, row_ids;  // into State::entries, State::rows
};

/// Springs on contact nodes, over the largest diagonal entry there: stiff enough to hold the patch,
/// soft enough to lose two digits only when they are taken off again.
constexpr double kSpring = 10;

using FloatMatrix = Eigen::Map<const Eigen::MatrixXf>;

}  // namespace

struct SchurFactor::State {
  cholmod_common common;
  cholmod_factor* factor = nullptr;
  const SymmetricBlockMatrix* pattern = nullptr;

  std::vector<std::int32_t> contact_nodes;
  std::vector<std::int32_t> order;  // unknown at each place of the factor
  std::int32_t inner = 0;           // places before the dense block
  std::vector<Panel> panels;
  std::vector<float> entries;
  std::vector<std::int32_t> rows;
  Eigen::MatrixXd schur;
  Eigen::MatrixXf dense;  // lower factor of S + C
  bool is_factored = false;
  double spring = 0;  // on the contact nodes while factoring [N/m]
  Eigen::VectorXf x, below;

  State() {
    cholmod_start(&common);
    common.print = 0;
    common.error_handler = nullptr;
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.final_ll = 1;
    common.quick_return_if_not_posdef = 1;
  }
  ~State() {
    cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
  }

  /// A view of our arrays; CHOLMOD does not write to them.
  static cholmod_sparse view(std::size_t size, const std::vector<std::int32_t>& starts,
                             const std::vector<std::int32_t>& rows, const double* values) {
    cholmod_sparse matrix{};
    matrix.nrow = matrix.ncol = size;
    matrix.nzmax = rows.size();
    matrix.p = const_cast<std::int32_t*>(starts.data());
    matrix.i = const_cast<std::int32_t*>(rows.data());
    matrix.x = const_cast<double*>(values);
    matrix.stype = -1;
    matrix.itype = CHOLMOD_INT;
    matrix.xtype = values ? CHOLMOD_REAL : CHOLMOD_PATTERN;
    matrix.dtype = CHOLMOD_DOUBLE;
    matrix.sorted = matrix.packed = 1;
    return matrix;
  }

  /// Nested dissection of the graph of all nodes but the contact nodes, which come last.
  std::vector<std::int32_t> node_order() {
    const int n = pattern->nodes();
    std::vector<std::int32_t> inner_index(n, 0);
    for (const std::int32_t node : contact_nodes) inner_index[node] = -1;
    std::vector<std::int32_t> nodes;
    for (int j = 0; j < n; ++j)
      if (inner_index[j] == 0) inner_index[j] = static_cast<std::int32_t>(nodes.size()), nodes.push_back(j);
    std::vector<std::int32_t> starts{0}, graph_rows;
    for (const std::int32_t j : nodes) {
      for (std::int32_t b = pattern->block_start()[j]; b < pattern->block_start()[j + 1]; ++b)
        if (const std::int32_t i = inner_index[pattern->block_row()[b]]; i >= 0) graph_rows.push_back(i);
      starts.push_back(static_cast<std::int32_t>(graph_rows.size()));
    }
    cholmod_sparse graph = view(nodes.size(), starts, graph_rows, nullptr);
    std::vector<std::int32_t> inner_order(nodes.size());
    {
      // METIS draws from one random sequence per process, seeded at its start: one at a time, or the
      // order (and with it the last bits of every force) depends on what other threads do.
      static std::mutex one_at_a_time;
      const std::lock_guard<std::mutex> lock(one_at_a_time);
      if (!cholmod_metis(&graph, nullptr, 0, 1, inner_order.data(), &common) &&
          !cholmod_amd(&graph, nullptr, 0, inner_order.data(), &common))
        throw std::bad_alloc();
    }
    std::vector<std::int32_t> out;
    for (const std::int32_t i : inner_order) out.push_back(nodes[i]);
    out.insert(out.end(), contact_nodes.begin(), contact_nodes.end());
    return out;
  }

  void analyse() {
    std::vector<std::int32_t> unknowns;
    for (const std::int32_t node : node_order())
      for (int c = 0; c < 3; ++c) unknowns.push_back(3 * node + c);
    common.nmethods = 1;
    common.method[0].ordering = CHOLMOD_GIVEN;
    cholmod_free_factor(&factor, &common);
    cholmod_sparse matrix = view(unknowns.size(), pattern->column_start(), pattern->row_index(),
                                 pattern->values().data());
    factor = cholmod_analyze_p(&matrix, unknowns.data(), nullptr, 0, &common);
    if (!factor) throw std::bad_alloc();
    const auto* perm = static_cast<const std::int32_t*>(factor->Perm);
    order.assign(perm, perm + factor->n);
    settle_contact_block();
  }

  /// The elimination order is post-ordered by CHOLMOD. Contact nodes form a chain at the top of the
  /// elimination tree and so stay last, unless the body falls apart; then there is no dense block.
  void settle_contact_block() {
    inner = static_cast<std::int32_t>(order.size() - 3 * contact_nodes.size());
    std::vector<char> is_contact(pattern->nodes(), 0);
    for (const std::int32_t node : contact_nodes) is_contact[node] = 1;
    bool is_last = true;
    for (std::size_t k = inner; k < order.size(); k += 3)
      is_last &= is_contact[order[k] / 3] && order[k] % 3 == 0 && order[k + 1] == order[k] + 1 &&
                 order[k + 2] == order[k] + 2;
    contact_nodes.clear();
    if (!is_last) inner = static_cast<std::int32_t>(order.size());
    for (std::size_t k = inner; k < order.size(); k += 3) contact_nodes.push_back(order[k] / 3);
  }

  /// Copies the columns before the dense block to single precision and forms S from the rest.
  void keep_factor() {
    const auto* super = static_cast<const std::int32_t*>(factor->super);
    const auto* row_start = static_cast<const std::int32_t*>(factor->pi);
    const auto* entry_start = static_cast<const std::int32_t*>(factor->px);
    const auto* row_of = static_cast<const std::int32_t*>(factor->s);
    const auto* values = static_cast<const double*>(factor->x);
    const int size = static_cast<int>(order.size()) - inner;
    Eigen::MatrixXd last = Eigen::MatrixXd::Zero(size, size);
    panels.clear(), entries.clear(), rows.clear();
    for (std::size_t s = 0; s < factor->nsuper; ++s) {
      const std::int32_t first = super[s], end = super[s + 1], height = row_start[s + 1] - row_start[s];
      const double* panel = values + entry_start[s];
      const std::int32_t* ids = row_of + row_start[s];
      const std::int32_t kept = std::clamp(inner - first, 0, end - first);
      if (kept > 0) {
        panels.push_back({first, kept, height, entries.size(), rows.size()});
        entries.insert(entries.end(), panel, panel + std::size_t(kept) * height);
        rows.insert(rows.end(), ids, ids + height);
      }
      for (std::int32_t c = first + kept; c < end; ++c)
        for (std::int32_t r = c - first; r < height; ++r)
          last(ids[r] - inner, c - inner) = panel[std::size_t(c - first) * height + r];
    }
    schur.resize(size, size);
    dense.resize(0, 0);  // never the block of an earlier analysis
    if (size == 0) return;
    const double one = 1, zero = 0;
    dsyrk_("L", "N", &size, &size, &one, last.data(), &size, &zero, schur.data(), &size);
    schur.triangularView<Eigen::StrictlyUpper>() = schur.transpose();
    schur.diagonal().array() -= spring;
    dense = schur.cast<float>();
    int info = 0;
    spotrf_("L", &size, dense.data(), &size, &info);
    if (info != 0) dense = last.cast<float>();  // not stable without the probe: keep the springs
  }

  void forward() {
    for (const Panel& panel : panels) {
      const FloatMatrix L(entries.data() + panel.entries, panel.rows, panel.columns);
      auto own = x.segment(panel.first, panel.columns);
      L.topRows(panel.columns).triangularView<Eigen::Lower>().solveInPlace(own);
      const std::int32_t under = panel.rows - panel.columns;
      if (under == 0) continue;
      below.head(under).noalias() = L.bottomRows(under) * own;
      const std::int32_t* ids = rows.data() + panel.row_ids + panel.columns;
      for (std::int32_t r = 0; r < under; ++r) x[ids[r]] -= below[r];
    }
  }

  void backward() {
    for (auto panel = panels.rbegin(); panel != panels.rend(); ++panel) {
      const FloatMatrix L(entries.data() + panel->entries, panel->rows, panel->columns);
      auto own = x.segment(panel->first, panel->columns);
      const std::int32_t under = panel->rows - panel->columns;
      const std::int32_t* ids = rows.data() + panel->row_ids + panel->columns;
      for (std::int32_t r = 0; r < under; ++r) below[r] = x[ids[r]];
      if (under > 0) own.noalias() -= L.bottomRows(under).transpose() * below.head(under);
      L.topRows(panel->columns).transpose().triangularView<Eigen::Upper>().solveInPlace(own);
    }
  }

  void load(const Eigen::VectorXd& b) {
    x.resize(b.size()), below.resize(b.size());
    for (Eigen::Index k = 0; k < b.size(); ++k) x[k] = static_cast<float>(b[order[k]]);
  }
  void unload(Eigen::VectorXd& out) const {
    out.resize(x.size());
    for (Eigen::Index k = 0; k < x.size(); ++k) out[order[k]] = x[k];
  }
  void solve_dense(float* b) const {
    const int size = static_cast<int>(dense.rows()), one = 1;
    int info = 0;
    if (size > 0) spotrs_("L", &size, &one, dense.data(), &size, b, &size, &info);
  }
};

SchurFactor::SchurFactor(const SymmetricBlockMatrix& pattern) : state_(std::make_unique<State>()) {
  state_->pattern = &pattern;
}
SchurFactor::~SchurFactor() = default;
SchurFactor::SchurFactor(SchurFactor&&) noexcept = default;
SchurFactor& SchurFactor::operator=(SchurFactor&&) noexcept = default;

bool SchurFactor::factor(SymmetricBlockMatrix& K,
                         const std::vector<std::int32_t>& contact_nodes) {
  use_one_thread();
  State& state = *state_;
  std::vector<std::int32_t> before = state.contact_nodes, wanted = contact_nodes;
  std::sort(before.begin(), before.end()), std::sort(wanted.begin(), wanted.end());
  state.pattern = &K;
  if (!state.factor || before != wanted) {
    state.contact_nodes = wanted;
    state.analyse();
  }
  state.spring = 0;
  for (const std::int32_t node : state.contact_nodes)
    state.spring = std::max(state.spring, kSpring * K.diagonal_entry(3 * node));
  for (const std::int32_t node : state.contact_nodes) K.add_to_diagonal(node, state.spring);
  cholmod_sparse matrix = State::view(K.size(), K.column_start(), K.row_index(), K.values().data());
  cholmod_factorize(&matrix, state.factor, &state.common);
  for (const std::int32_t node : state.contact_nodes) K.add_to_diagonal(node, -state.spring);
  if (state.common.status == CHOLMOD_OUT_OF_MEMORY) throw std::bad_alloc();
  state.is_factored = state.common.status == CHOLMOD_OK;
  if (state.is_factored) state.keep_factor();
  return state.is_factored;
}

bool SchurFactor::is_factored() const { return state_->is_factored; }
const std::vector<std::int32_t>& SchurFactor::contact_nodes() const { return state_->contact_nodes; }
const Eigen::MatrixXd& SchurFactor::schur() const { return state_->schur; }

bool SchurFactor::set_contact(const Eigen::MatrixXd& C) {
  const int size = static_cast<int>(state_->schur.rows());
  if (size == 0) return true;
  Eigen::MatrixXf sum = (state_->schur + C).cast<float>();
  int info = 0;
  spotrf_("L", &size, sum.data(), &size, &info);
  if (info == 0) state_->dense = std::move(sum);
  return info == 0;
}

void SchurFactor::solve(const Eigen::VectorXd& b, Eigen::VectorXd& x) {
  state_->load(b);
  state_->forward();
  state_->solve_dense(state_->x.data() + state_->inner);
  state_->backward();
  state_->unload(x);
}

void SchurFactor::reduce(const Eigen::VectorXd& b, Eigen::VectorXd& reduced) {
  state_->load(b);
  state_->forward();
  reduced = state_->x.tail(state_->x.size() - state_->inner).cast<double>();
}

void SchurFactor::expand(const Eigen::VectorXd& contact_displacement, Eigen::VectorXd& x) {
  state_->x.tail(contact_displacement.size()) = contact_displacement.cast<float>();
  state_->backward();
  state_->unload(x);
}

void SchurFactor::solve_contact(const Eigen::VectorXd& b, Eigen::VectorXd& x) const {
  Eigen::VectorXf single = b.cast<float>();
  state_->solve_dense(single.data());
  x = single.cast<double>();
}

double SchurFactor::factor_flops() const { return state_->common.fl; }
std::int64_t SchurFactor::factor_entries() const {
  return static_cast<std::int64_t>(state_->common.lnz);
}

}  // namespace palpate::fem
