#include "libfem/solve/schur_factor.hpp"

#include <algorithm>

#include "libfem/solve/multifrontal.hpp"

extern "C" {
// Present when the BLAS is OpenBLAS and when CHOLMOD was built with OpenMP; other builds of either
// need no such call.
void openblas_set_num_threads(int) __attribute__((weak));
void omp_set_max_active_levels(int) __attribute__((weak));
// BLAS and LAPACK, Fortran interface.
void spotrf_(const char* uplo, const int* n, float* a, const int* lda, int* info);
void sgemv_(const char* trans, const int* m, const int* n, const float* alpha, const float* a,
            const int* lda, const float* x, const int* incx, const float* beta, float* y,
            const int* incy);
void strsv_(const char* uplo, const char* trans, const char* diag, const int* n, const float* a,
            const int* lda, float* x, const int* incx);
void spotrs_(const char* uplo, const int* n, const int* right_sides, const float* a, const int* lda,
             float* b, const int* ldb, int* info);
}

namespace palpate::fem {
namespace {

constexpr double kMostSprings = 1e6;  // in the largest stiffness of a contact node

void use_one_thread() {
  if (openblas_set_num_threads) openblas_set_num_threads(1);
  if (omp_set_max_active_levels) omp_set_max_active_levels(0);
}

}  // namespace

struct SchurFactor::State {
  std::vector<std::int32_t> node_order;  // of the pattern, whatever the contact nodes
  Elimination plan;
  FrontalFactor frontal;
  Eigen::MatrixXf dense;  // lower factor of S + C
  bool is_factored = false;
  bool needs_double = false;  // single precision has failed where double has not
  Profile* profile = nullptr;
  Eigen::VectorXf x, below;

  void analyse(const SymmetricBlockMatrix& K, const std::vector<std::int32_t>& contact_nodes) {
    const PhaseTimer timer(profile, Phase::analysis);
    if (node_order.empty()) node_order = dissect(K);
    plan = analyse_elimination(K, node_order, contact_nodes);
    x.resize(K.size()), below.resize(K.size());
  }

  bool factor(const SymmetricBlockMatrix& K) {
    if (needs_double || !eliminate<float>(plan, K, frontal)) {
      if (!eliminate<double>(plan, K, frontal)) return false;
      needs_double = true;
    }
    // Without the probe the body may not be stable: springs then stand in for it.
    Eigen::MatrixXd held = frontal.schur;
    for (double springs = 0.03; !factor_dense(held); springs *= 10) {
      if (!(springs < kMostSprings)) return false;  // not a number somewhere
      held.diagonal().array() += springs * frontal.schur.diagonal().cwiseAbs().maxCoeff();
    }
    return true;
  }

  bool factor_dense(const Eigen::MatrixXd& matrix) {
    const int size = static_cast<int>(matrix.rows());
    Eigen::MatrixXf sum = matrix.cast<float>();
    int info = 0;
    if (size > 0) spotrf_("L", &size, sum.data(), &size, &info);
    if (info == 0) dense = std::move(sum);
    return info == 0;
  }

  void forward() {
    const float one = 1, zero = 0;
    const int step = 1;
    for (int s = 0; s < plan.supernodes(); ++s) {
      const float* L = frontal.panels.data() + frontal.panel_start[s];
      const int height = 3 * plan.height(s), own = 3 * plan.columns(s), under = height - own;
      float* mine = x.data() + 3 * plan.first[s];
      strsv_("L", "N", "N", &own, L, &height, mine, &step);
      if (under == 0) continue;
      sgemv_("N", &under, &own, &one, L + own, &height, mine, &step, &zero, below.data(), &step);
      const std::int32_t* rows = plan.rows.data() + plan.row_start[s] + plan.columns(s);
      for (int r = 0; r < under; r += 3) x.segment<3>(3 * rows[r / 3]) -= below.segment<3>(r);
    }
  }

  void backward() {
    const float one = 1, minus_one = -1;
    const int step = 1;
    for (int s = plan.supernodes() - 1; s >= 0; --s) {
      const float* L = frontal.panels.data() + frontal.panel_start[s];
      const int height = 3 * plan.height(s), own = 3 * plan.columns(s), under = height - own;
      float* mine = x.data() + 3 * plan.first[s];
      const std::int32_t* rows = plan.rows.data() + plan.row_start[s] + plan.columns(s);
      for (int r = 0; r < under; r += 3) below.segment<3>(r) = x.segment<3>(3 * rows[r / 3]);
      if (under > 0)
        sgemv_("T", &under, &own, &minus_one, L + own, &height, below.data(), &step, &one, mine,
               &step);
      strsv_("L", "T", "N", &own, L, &height, mine, &step);
    }
  }

  void load(const Eigen::VectorXd& b) {
    for (std::size_t k = 0; k < plan.order.size(); ++k)
      x.segment<3>(3 * k) = b.segment<3>(3 * plan.order[k]).cast<float>();
  }
  void unload(Eigen::VectorXd& out) const {
    out.resize(x.size());
    for (std::size_t k = 0; k < plan.order.size(); ++k)
      out.segment<3>(3 * plan.order[k]) = x.segment<3>(3 * k).cast<double>();
  }
  void solve_dense(float* b) const {
    const int size = static_cast<int>(dense.rows()), one = 1;
    int info = 0;
    if (size > 0) spotrs_("L", &size, &one, dense.data(), &size, b, &size, &info);
  }
};

SchurFactor::SchurFactor() : state_(std::make_unique<State>()) {}
SchurFactor::~SchurFactor() = default;
SchurFactor::SchurFactor(SchurFactor&&) noexcept = default;
SchurFactor& SchurFactor::operator=(SchurFactor&&) noexcept = default;

bool SchurFactor::factor(const SymmetricBlockMatrix& K,
                         const std::vector<std::int32_t>& contact_nodes) {
  use_one_thread();
  const PhaseTimer timer(state_->profile, Phase::factor);
  State& state = *state_;
  std::vector<std::int32_t> have = state.plan.last_nodes, wanted = contact_nodes;
  std::sort(have.begin(), have.end()), std::sort(wanted.begin(), wanted.end());
  if (state.plan.order.empty() || have != wanted) state.analyse(K, wanted);
  state.is_factored = state.factor(K);
  return state.is_factored;
}

bool SchurFactor::is_factored() const { return state_->is_factored; }
const std::vector<std::int32_t>& SchurFactor::contact_nodes() const {
  return state_->plan.last_nodes;
}
const Eigen::MatrixXd& SchurFactor::schur() const { return state_->frontal.schur; }

bool SchurFactor::set_contact(const Eigen::MatrixXd& C) {
  return state_->factor_dense(state_->frontal.schur + C);
}

void SchurFactor::solve(const Eigen::VectorXd& b, Eigen::VectorXd& x) {
  state_->load(b);
  state_->forward();
  state_->solve_dense(state_->x.data() + 3 * state_->plan.inner);
  state_->backward();
  state_->unload(x);
}

void SchurFactor::reduce(const Eigen::VectorXd& b, Eigen::VectorXd& reduced) {
  state_->load(b);
  state_->forward();
  reduced = state_->x.tail(state_->frontal.schur.rows()).cast<double>();
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

void SchurFactor::count_time(Profile* profile) { state_->profile = profile; }

void SchurFactor::use_double() { state_->needs_double = true; }
std::int64_t SchurFactor::memory_bytes() const {
  const State& state = *state_;
  return static_cast<std::int64_t>(
      sizeof(float) * (state.frontal.panels.size() + static_cast<std::size_t>(state.dense.size())) +
      sizeof(double) * static_cast<std::size_t>(state.frontal.schur.size()) +
      sizeof(std::int32_t) * (3 * state.plan.order.size() + state.plan.rows.size()) +
      state.frontal.scratch_bytes);
}

double SchurFactor::factor_flops() const { return state_->plan.flops; }
std::int64_t SchurFactor::factor_entries() const { return state_->plan.entries; }

}  // namespace palpate::fem
