#include "libfem/solve/cholesky.hpp"

#include <suitesparse/cholmod.h>

#include <mutex>
#include <new>
#include <stdexcept>
#include <vector>

// Present when the BLAS is OpenBLAS and when CHOLMOD was built with OpenMP; other builds of either
// need no such call.
extern "C" {
void openblas_set_num_threads(int) __attribute__((weak));
void omp_set_max_active_levels(int) __attribute__((weak));
}

namespace palpate::fem {
namespace {

void use_one_thread() {
  if (openblas_set_num_threads) openblas_set_num_threads(1);
  if (omp_set_max_active_levels) omp_set_max_active_levels(0);
}

}  // namespace

struct Cholesky::State {
  cholmod_common common;
  cholmod_factor* factor = nullptr;
  cholmod_sparse matrix{};
  cholmod_dense *x = nullptr, *y = nullptr, *e = nullptr;
  double flops = 0, entries = 0;
  bool is_factored = false;

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
    cholmod_free_dense(&x, &common);
    cholmod_free_dense(&y, &common);
    cholmod_free_dense(&e, &common);
    cholmod_finish(&common);
  }

  /// A view of our arrays; CHOLMOD does not write to them.
  void view(const SymmetricBlockMatrix& K) {
    matrix = {};
    matrix.nrow = matrix.ncol = static_cast<std::size_t>(K.size());
    matrix.nzmax = K.row_index().size();
    matrix.p = const_cast<std::int32_t*>(K.column_start().data());
    matrix.i = const_cast<std::int32_t*>(K.row_index().data());
    matrix.x = const_cast<double*>(K.values().data());
    matrix.stype = -1;
    matrix.itype = CHOLMOD_INT;
    matrix.xtype = CHOLMOD_REAL;
    matrix.dtype = CHOLMOD_DOUBLE;
    matrix.sorted = matrix.packed = 1;
  }

  /// Nested dissection of the node graph, three times smaller than that of the unknowns.
  std::vector<std::int32_t> node_order(const SymmetricBlockMatrix& K) {
    cholmod_sparse graph{};
    graph.nrow = graph.ncol = static_cast<std::size_t>(K.nodes());
    graph.nzmax = K.block_row().size();
    graph.p = const_cast<std::int32_t*>(K.block_start().data());
    graph.i = const_cast<std::int32_t*>(K.block_row().data());
    graph.stype = -1;
    graph.itype = CHOLMOD_INT;
    graph.xtype = CHOLMOD_PATTERN;
    graph.sorted = graph.packed = 1;
    std::vector<std::int32_t> order(K.nodes());
    // METIS draws from one random sequence per process, seeded at its start: one at a time, or the
    // order (and with it the last bits of every force) depends on what other threads do.
    static std::mutex one_at_a_time;
    const std::lock_guard<std::mutex> lock(one_at_a_time);
    if (!cholmod_metis(&graph, nullptr, 0, 1, order.data(), &common) &&
        !cholmod_amd(&graph, nullptr, 0, order.data(), &common))
      throw std::bad_alloc();
    return order;
  }

  void analyse(const SymmetricBlockMatrix& K) {
    std::vector<std::int32_t> order(K.size());
    const std::vector<std::int32_t> nodes = node_order(K);
    for (int k = 0; k < K.nodes(); ++k)
      for (int c = 0; c < 3; ++c) order[3 * k + c] = 3 * nodes[k] + c;
    common.nmethods = 1;
    common.method[0].ordering = CHOLMOD_GIVEN;
    view(K);
    factor = cholmod_analyze_p(&matrix, order.data(), nullptr, 0, &common);
    if (!factor) throw std::bad_alloc();
    flops = common.fl;
    entries = common.lnz;
  }
};

Cholesky::Cholesky(const SymmetricBlockMatrix& pattern) : state_(std::make_unique<State>()) {
  use_one_thread();
  state_->analyse(pattern);
}
Cholesky::~Cholesky() = default;
Cholesky::Cholesky(Cholesky&&) noexcept = default;
Cholesky& Cholesky::operator=(Cholesky&&) noexcept = default;

bool Cholesky::factor(const SymmetricBlockMatrix& K) {
  use_one_thread();
  state_->view(K);
  cholmod_factorize(&state_->matrix, state_->factor, &state_->common);
  if (state_->common.status == CHOLMOD_OUT_OF_MEMORY) throw std::bad_alloc();
  state_->is_factored = state_->common.status == CHOLMOD_OK;
  return state_->is_factored;
}

bool Cholesky::is_factored() const { return state_->is_factored; }

void Cholesky::solve(const Eigen::VectorXd& b, Eigen::VectorXd& x) const {
  cholmod_dense right{};
  right.nrow = right.d = right.nzmax = static_cast<std::size_t>(b.size());
  right.ncol = 1;
  right.x = const_cast<double*>(b.data());
  right.xtype = CHOLMOD_REAL;
  right.dtype = CHOLMOD_DOUBLE;
  if (!cholmod_solve2(CHOLMOD_A, state_->factor, &right, nullptr, &state_->x, nullptr, &state_->y,
                      &state_->e, &state_->common))
    throw std::bad_alloc();
  x = Eigen::Map<const Eigen::VectorXd>(static_cast<const double*>(state_->x->x), b.size());
}

double Cholesky::factor_flops() const { return state_->flops; }
std::int64_t Cholesky::factor_entries() const { return static_cast<std::int64_t>(state_->entries); }

}  // namespace palpate::fem
