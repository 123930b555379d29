#include "libfem/solve/factor/schur_factor.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <atomic>

#include "libfem/solve/factor/dense_kernels.hpp"
#include "libfem/solve/factor/multifrontal.hpp"
#include "libfem/solve/factor/panel_kernels.hpp"
#include "libfit/core/error.hpp"

namespace palpate::fem {
namespace {

constexpr double kMaxSprings = 1e6;  // in the largest stiffness of a contact node

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

}  // namespace

void bound_factor_memory(double bytes) { max_bytes = bytes; }

struct SchurFactor::State {
  std::vector<std::int32_t> node_order;  // of the pattern, whatever the contact nodes
  Elimination plan;
  FrontalFactor frontal;
  EliminationRoom<float> room;
  EliminationRoom<double> double_room;
  Eigen::MatrixXf flexibility;
  bool is_factored = false;
  bool needs_double = false;  // single precision has failed where double has not
  PanelKernels kernels = panel_kernels(best_instruction_set());
  Eigen::VectorXf x, work;

  void analyse(const SymmetricBlockMatrix& K, const std::vector<std::int32_t>& contact_nodes) {
    if (node_order.empty()) node_order = dissect(K);
    plan = analyse_elimination(K, node_order, contact_nodes);
    check_memory(plan);
    x.resize(K.size());
    std::size_t most = 0;
    for (int s = 0; s < plan.supernodes(); ++s)
      most = std::max(most,
                      panel_work_size(3 * plan.columns(s), 3 * (plan.height(s) - plan.columns(s))));
    work.resize(static_cast<Eigen::Index>(most));
  }

  bool factor(const SymmetricBlockMatrix& K) {
    if (needs_double || !eliminate(plan, K, room, frontal)) {
      if (!eliminate(plan, K, double_room, frontal)) return false;
      needs_double = true;
    }
    // Without the probe the body may not be stable: springs then stand in for it.
    Eigen::MatrixXd held = frontal.schur;
    for (double springs = 0.03; !factor_dense(held, flexibility); springs *= 10) {
      if (!(springs < kMaxSprings)) return false;  // not a number somewhere
      held.diagonal().array() += springs * frontal.schur.diagonal().cwiseAbs().maxCoeff();
    }
    dense_kernels().invert_from_factor(flexibility.data(), static_cast<int>(flexibility.rows()));
    return true;
  }

  /// Lower factor; false when `matrix` is not positive definite.
  static bool factor_dense(const Eigen::MatrixXd& matrix, Eigen::MatrixXf& out) {
    const int size = static_cast<int>(matrix.rows());
    out = matrix.cast<float>();
    return dense_kernels().factor_front(out.data(), size, size);
  }

  PanelTask task_of(int s) {
    return {frontal.panels.data() + frontal.panel_start[s],
            3 * plan.columns(s),
            3 * (plan.height(s) - plan.columns(s)),
            plan.rows.data() + plan.row_start[s] + plan.columns(s),
            x.data(),
            x.data() + std::ptrdiff_t{3} * plan.first[s],
            work.data()};
  }

  void forward() {
    for (int s = 0; s < plan.supernodes(); ++s) kernels.forward(task_of(s));
  }

  void backward() {
    for (int s = plan.supernodes() - 1; s >= 0; --s) kernels.backward(task_of(s));
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
};

SchurFactor::SchurFactor() : state_(std::make_unique<State>()) {}
SchurFactor::~SchurFactor() = default;
SchurFactor::SchurFactor(SchurFactor&&) noexcept = default;
SchurFactor& SchurFactor::operator=(SchurFactor&&) noexcept = default;

bool SchurFactor::factor(const SymmetricBlockMatrix& K,
                         const std::vector<std::int32_t>& contact_nodes) {
  State& state = *state_;
  std::vector<std::int32_t> have = state.plan.last_nodes, wanted = contact_nodes;
  std::sort(have.begin(), have.end());
  std::sort(wanted.begin(), wanted.end());
  if (state.plan.order.empty() || have != wanted) state.analyse(K, wanted);
  state.is_factored = state.factor(K);
  return state.is_factored;
}

bool SchurFactor::is_factored() const { return state_->is_factored; }
const std::vector<std::int32_t>& SchurFactor::contact_nodes() const {
  return state_->plan.last_nodes;
}
const Eigen::MatrixXd& SchurFactor::schur() const { return state_->frontal.schur; }

const Eigen::MatrixXf& SchurFactor::flexibility() const { return state_->flexibility; }

bool SchurFactor::is_stable_with(const Eigen::MatrixXd& C) const {
  Eigen::MatrixXf unused;
  return State::factor_dense(state_->frontal.schur + C, unused);
}

void SchurFactor::solve(const Eigen::VectorXd& b, Eigen::VectorXd& x) {
  Eigen::VectorXd load;
  reduce(b, load);
  expand((state_->flexibility * load.cast<float>()).cast<double>(), x);
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
  // As it was given: stiff contact would feel it rounded.
  for (std::size_t i = 0; i < contact_nodes().size(); ++i)
    x.segment<3>(3 * contact_nodes()[i]) = contact_displacement.segment<3>(3 * i);
}

}  // namespace palpate::fem
