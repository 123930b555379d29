#include "libfem/solve/factor/schur_factor.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <atomic>

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

}  // namespace palpate::fem
