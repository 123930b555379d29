#include "libfem/solve/schur_factor.hpp"

#include <algorithm>

#include "libfem/solve/elimination.hpp"

extern "C" {
// Present when the BLAS is OpenBLAS and when CHOLMOD was built with OpenMP; other builds of either
// need no such call.
void openblas_set_num_threads(int) __attribute__((weak));
void omp_set_max_active_levels(int) __attribute__((weak));
// BLAS and LAPACK, Fortran interface.
void spotrf_(const char* uplo, const int* n, float* a, const int* lda, int* info);
void spotrs_(const char* uplo, const int* n, const int* right_sides, const float* a, const int* lda,
             float* b, const int* ldb, int* info);
void strsm_(const char* side, const char* uplo, const char* trans, const char* diag, const int* m,
            const int* n, const float* alpha, const float* a, const int* lda, float* b,
            const int* ldb);
void ssyrk_(const char* uplo, const char* trans, const int* n, const int* k, const float* alpha,
            const float* a, const int* lda, const float* beta, float* c, const int* ldc);
}

namespace palpate::fem {
namespace {

void use_one_thread() {
  if (openblas_set_num_threads) openblas_set_num_threads(1);
  if (omp_set_max_active_levels) omp_set_max_active_levels(0);
}

/// An entry of K at its place: row (place of the later unknown) within a column, index of the value.
struct Entry {
  std::int32_t row, value;
};

using FloatMatrix = Eigen::Map<const Eigen::MatrixXf>;

}  // namespace

struct SchurFactor::State {
  std::vector<std::int32_t> node_order;     // of the pattern, whatever the contact nodes
  Elimination plan;
  std::vector<Entry> entries;               // of K by column of the elimination
  std::vector<std::int32_t> entry_start;    // size + 1
  std::vector<std::size_t> panel_start;     // of each supernode in `panels`
  std::vector<float> panels;                // rows x own columns each, column major
  std::vector<std::vector<float>> updates;  // of supernodes whose parent is still to come
  std::vector<std::vector<std::int32_t>> children;
  Eigen::MatrixXd schur;
  Eigen::MatrixXf dense;                    // lower factor of S + C
  std::vector<std::int32_t> position;       // of a row in the front at hand
  Eigen::VectorXf x, below;
  bool is_factored = false;

  int supernodes() const { return static_cast<int>(plan.first.size()) - 1; }
  int columns(int s) const { return plan.first[s + 1] - plan.first[s]; }
  int height(int s) const { return plan.row_start[s + 1] - plan.row_start[s]; }
  const std::int32_t* rows(int s) const { return plan.rows.data() + plan.row_start[s]; }
  int dense_size() const { return static_cast<int>(plan.order.size()) - plan.inner; }

  void analyse(const SymmetricBlockMatrix& K, const std::vector<std::int32_t>& contact_nodes) {
    if (node_order.empty()) node_order = dissect(K);
    plan = analyse_elimination(K, node_order, contact_nodes);
    place_entries(K);
    panel_start.assign(1, 0);
    children.assign(supernodes(), {});
    updates.assign(supernodes(), {});
    std::vector<std::int32_t> owner(plan.inner);
    for (int s = 0; s < supernodes(); ++s) {
      std::fill(owner.begin() + plan.first[s], owner.begin() + plan.first[s + 1], s);
      panel_start.push_back(panel_start.back() + std::size_t(height(s)) * columns(s));
    }
    for (int s = 0; s < supernodes(); ++s)
      if (height(s) > columns(s) && rows(s)[columns(s)] < plan.inner)
        children[owner[rows(s)[columns(s)]]].push_back(s);
    panels.resize(panel_start.back());
    position.resize(plan.order.size());
    x.resize(plan.order.size()), below.resize(plan.order.size());
  }

  void place_entries(const SymmetricBlockMatrix& K) {
    std::vector<std::int32_t> place(plan.order.size());
    for (std::size_t k = 0; k < place.size(); ++k) place[plan.order[k]] = static_cast<std::int32_t>(k);
    entry_start.assign(place.size() + 1, 0);
    const auto visit = [&](const auto& act) {
      for (int j = 0; j < K.size(); ++j)
        for (std::int32_t v = K.column_start()[j]; v < K.column_start()[j + 1]; ++v) {
          const std::int32_t a = place[j], b = place[K.row_index()[v]];
          act(std::min(a, b), Entry{std::max(a, b), v});
        }
    };
    visit([&](std::int32_t column, const Entry&) { ++entry_start[column + 1]; });
    for (std::size_t c = 0; c < place.size(); ++c) entry_start[c + 1] += entry_start[c];
    entries.resize(entry_start.back());
    std::vector<std::int32_t> next(entry_start.begin(), entry_start.end() - 1);
    visit([&](std::int32_t column, const Entry& entry) { entries[next[column]++] = entry; });
  }

  /// Adds a child's update (lower triangle, n x n) to a matrix of which `position` knows the rows.
  void extend_add(int child, float* target, std::size_t stride) {
    const int n = height(child) - columns(child);
    const std::int32_t* ids = rows(child) + columns(child);
    const float* update = updates[child].data();
    for (int j = 0; j < n; ++j) {
      float* column = target + stride * position[ids[j]];
      for (int i = j; i < n; ++i) column[position[ids[i]]] += update[std::size_t(n) * j + i];
    }
    updates[child] = {};
  }

  /// Assembles and eliminates one supernode. False when its pivots are not positive.
  bool eliminate(int s, const std::vector<double>& values) {
    const int own = columns(s), n = height(s), under = n - own;
    for (int r = 0; r < n; ++r) position[rows(s)[r]] = r;
    std::vector<float> front(std::size_t(n) * n, 0.0f);
    for (int c = 0; c < own; ++c)
      for (std::int32_t e = entry_start[plan.first[s] + c]; e < entry_start[plan.first[s] + c + 1]; ++e)
        front[std::size_t(n) * c + position[entries[e].row]] = static_cast<float>(values[entries[e].value]);
    for (const std::int32_t child : children[s]) extend_add(child, front.data(), n);
    int info = 0;
    spotrf_("L", &own, front.data(), &n, &info);
    if (info != 0) return false;
    const float one = 1, minus_one = -1;
    float* tail = front.data() + std::size_t(n) * own + own;
    if (under > 0) {
      strsm_("R", "L", "T", "N", &under, &own, &one, front.data(), &n, front.data() + own, &n);
      ssyrk_("L", "N", &under, &own, &minus_one, front.data() + own, &n, &one, tail, &n);
      std::vector<float>& update = updates[s];
      update.resize(std::size_t(under) * under);
      for (int j = 0; j < under; ++j)
        std::copy(tail + std::size_t(n) * j + j, tail + std::size_t(n) * j + under,
                  update.begin() + std::size_t(under) * j + j);
    }
    std::copy(front.begin(), front.begin() + std::size_t(n) * own, panels.begin() + panel_start[s]);
    return true;
  }

  /// What is left of K once all supernodes are eliminated.
  void gather_schur(const std::vector<double>& values) {
    const int size = dense_size();
    Eigen::MatrixXf sum = Eigen::MatrixXf::Zero(size, size);
    for (int c = 0; c < size; ++c) {
      position[plan.inner + c] = c;
      for (std::int32_t e = entry_start[plan.inner + c]; e < entry_start[plan.inner + c + 1]; ++e)
        sum(entries[e].row - plan.inner, c) = static_cast<float>(values[entries[e].value]);
    }
    for (int s = 0; s < supernodes(); ++s)
      if (!updates[s].empty()) extend_add(s, sum.data(), size);
    schur = sum.cast<double>();
    schur.triangularView<Eigen::StrictlyUpper>() = schur.transpose();
  }

  bool factor(const SymmetricBlockMatrix& K) {
    for (auto& update : updates) update = {};
    for (int s = 0; s < supernodes(); ++s)
      if (!eliminate(s, K.values())) return false;
    gather_schur(K.values());
    // Without the probe the body may not be stable: springs then stand in for it.
    Eigen::MatrixXd held = schur;
    for (double springs = 0.03; !factor_dense(held); springs *= 10)
      held.diagonal().array() += springs * schur.diagonal().cwiseAbs().maxCoeff();
    return true;
  }

  bool factor_dense(const Eigen::MatrixXd& matrix) {
    const int size = dense_size();
    Eigen::MatrixXf sum = matrix.cast<float>();
    int info = 0;
    if (size > 0) spotrf_("L", &size, sum.data(), &size, &info);
    if (info == 0) dense = std::move(sum);
    return info == 0;
  }

  void forward() {
    for (int s = 0; s < supernodes(); ++s) {
      const int own = columns(s), under = height(s) - own;
      const FloatMatrix L(panels.data() + panel_start[s], height(s), own);
      auto mine = x.segment(plan.first[s], own);
      L.topRows(own).triangularView<Eigen::Lower>().solveInPlace(mine);
      if (under == 0) continue;
      below.head(under).noalias() = L.bottomRows(under) * mine;
      const std::int32_t* ids = rows(s) + own;
      for (int r = 0; r < under; ++r) x[ids[r]] -= below[r];
    }
  }

  void backward() {
    for (int s = supernodes() - 1; s >= 0; --s) {
      const int own = columns(s), under = height(s) - own;
      const FloatMatrix L(panels.data() + panel_start[s], height(s), own);
      auto mine = x.segment(plan.first[s], own);
      const std::int32_t* ids = rows(s) + own;
      for (int r = 0; r < under; ++r) below[r] = x[ids[r]];
      if (under > 0) mine.noalias() -= L.bottomRows(under).transpose() * below.head(under);
      L.topRows(own).transpose().triangularView<Eigen::Upper>().solveInPlace(mine);
    }
  }

  void load(const Eigen::VectorXd& b) {
    for (Eigen::Index k = 0; k < b.size(); ++k) x[k] = static_cast<float>(b[plan.order[k]]);
  }
  void unload(Eigen::VectorXd& out) const {
    out.resize(x.size());
    for (Eigen::Index k = 0; k < x.size(); ++k) out[plan.order[k]] = x[k];
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
  State& state = *state_;
  std::vector<std::int32_t> have = state.plan.last_nodes, wanted = contact_nodes;
  std::sort(have.begin(), have.end()), std::sort(wanted.begin(), wanted.end());
  // A dense block of up to 1.3 times the nodes costs less than a new analysis.
  const bool is_enough = std::includes(have.begin(), have.end(), wanted.begin(), wanted.end()) &&
                         10 * have.size() <= 13 * wanted.size() + 100;
  if (state.plan.order.empty() || !is_enough) state.analyse(K, wanted);
  state.is_factored = state.factor(K);
  return state.is_factored;
}

bool SchurFactor::is_factored() const { return state_->is_factored; }
const std::vector<std::int32_t>& SchurFactor::contact_nodes() const {
  return state_->plan.last_nodes;
}
const Eigen::MatrixXd& SchurFactor::schur() const { return state_->schur; }

bool SchurFactor::set_contact(const Eigen::MatrixXd& C) {
  return state_->factor_dense(state_->schur + C);
}

void SchurFactor::solve(const Eigen::VectorXd& b, Eigen::VectorXd& x) {
  state_->load(b);
  state_->forward();
  state_->solve_dense(state_->x.data() + state_->plan.inner);
  state_->backward();
  state_->unload(x);
}

void SchurFactor::reduce(const Eigen::VectorXd& b, Eigen::VectorXd& reduced) {
  state_->load(b);
  state_->forward();
  reduced = state_->x.tail(state_->dense_size()).cast<double>();
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

double SchurFactor::factor_flops() const { return state_->plan.flops; }

}  // namespace palpate::fem
