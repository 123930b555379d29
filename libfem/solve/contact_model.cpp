#include "libfem/solve/contact_model.hpp"

#include <array>

namespace palpate::fem {

ContactModel::ContactModel(const QuadraticMesh& mesh, const ElasticBody& body, Contact& contact,
                           SchurFactor& factor)
    : mesh_(mesh), body_(body), contact_(contact), factor_(factor) {}

void ContactModel::settle() {
  std::vector<std::int32_t> place(body_.free_nodes(), -1);
  for (std::size_t i = 0; i < factor_.contact_nodes().size(); ++i)
    place[factor_.contact_nodes()[i]] = static_cast<std::int32_t>(i);
  block_of_.assign(body_.free_index().size(), -1);
  node_of_.assign(factor_.contact_nodes().size(), -1);
  for (std::size_t n = 0; n < block_of_.size(); ++n) {
    const std::int32_t i = body_.free_index()[n];
    if (i < 0 || place[i] < 0) continue;
    block_of_[n] = place[i];
    node_of_[place[i]] = static_cast<std::int32_t>(n);
  }
}

void ContactModel::gather_terms() {
  using Block = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;
  const auto size = static_cast<Eigen::Index>(3 * node_of_.size());
  stiffness_.setZero(size, size);
  force_.setZero(size);
  for (const FaceTerms& face : contact_.terms()) {
    std::array<std::int32_t, kFaceNodes> at;
    for (int a = 0; a < kFaceNodes; ++a) at[a] = 3 * block_of_[mesh_.faces(face.face, a)];
    for (int a = 0; a < kFaceNodes; ++a) {
      if (at[a] < 0) continue;
      force_.segment<3>(at[a]) += Eigen::Map<const Vec3>(face.force + 3 * a);
      for (int b = 0; b <= a; ++b) {
        if (at[b] < 0) continue;
        const Block block(face.stiffness + 9 * (a * (a + 1) / 2 + b));  // symmetric
        stiffness_.block<3, 3>(at[a], at[b]) += block;
        if (a != b) stiffness_.block<3, 3>(at[b], at[a]) += block;
      }
    }
  }
}

bool ContactModel::use_contact_stiffness(const Points& u, const ProbePose& pose,
                                         const ContactHistory& history) {
  gather_terms();
  if (factor_.set_contact(stiffness_)) return true;
  contact_.evaluate(u, pose, history, false);
  gather_terms();
  if (factor_.set_contact(stiffness_)) return true;
  const double unit = factor_.schur().diagonal().cwiseAbs().maxCoeff();
  for (const double springs : {0.03, 0.3, 3.0}) {
    stiffness_.diagonal().array() += springs * unit;
    if (factor_.set_contact(stiffness_)) return true;
  }
  return false;
}

void ContactModel::place(const Points& u, const Eigen::VectorXd& w, Points& out) const {
  for (std::size_t i = 0; i < node_of_.size(); ++i)
    out.row(node_of_[i]) = u.row(node_of_[i]) + w.segment<3>(3 * i).transpose();
}

// Where the probe was touched before, the surface goes with it; elsewhere it stays.
Eigen::VectorXd ContactModel::stuck_start(const Points& u, const Points& stuck,
                                          const ContactHistory& history) const {
  Eigen::VectorXd w = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * node_of_.size()));
  for (const std::int32_t n : contact_.pressed_nodes(history))
    if (block_of_[n] >= 0) w.segment<3>(3 * block_of_[n]) = (stuck.row(n) - u.row(n)).transpose();
  return w;
}

std::optional<Eigen::VectorXd> ContactModel::solve(
    const Points& u, const Points& elastic_force, const ProbePose& pose,
    const ContactHistory& history, const std::optional<Points>& stuck,
    const ContactModelOptions& options, int& iterations) {
  if (node_of_.empty()) return std::nullopt;
  Eigen::VectorXd pull(3 * body_.free_nodes()), load, step, direction;
  for (Eigen::Index n = 0; n < u.rows(); ++n)
    if (const std::int32_t i = body_.free_index()[n]; i >= 0)
      pull.segment<3>(3 * i) = -elastic_force.row(n).transpose();
  factor_.reduce(pull, load);

  const Eigen::MatrixXd& S = factor_.schur();
  Points moved = u;
  const auto energy = [&](const Eigen::VectorXd& w) {
    place(u, w, moved);
    return w.dot(0.5 * (S * w) - load) + contact_.energy(moved, pose, history);
  };
  Eigen::VectorXd w = Eigen::VectorXd::Zero(load.size());
  if (stuck) {
    const Eigen::VectorXd other = stuck_start(u, *stuck, history);
    if (energy(other) < energy(w)) w = other;
  }
  int rounds = 0;
  for (int iteration = 0; iteration < options.most_iterations; ++iteration) {
    place(u, w, moved);
    contact_.evaluate(moved, pose, history);
    gather_terms();
    const Eigen::VectorXd residual = load - S * w - force_;
    if (residual.norm() <= options.residual * force_.norm()) {
      if (++rounds == options.most_rounds) break;
      if (contact_.hold_friction_limit(moved, pose, history) < options.limit_change) break;
      continue;
    }
    ++iterations;
    if (!use_contact_stiffness(moved, pose, history)) return std::nullopt;
    factor_.solve_contact(residual, step);
    const double start = energy(w), slope = -residual.dot(step);
    double length = 1;
    for (int cut = 0; cut < 8; ++cut, length /= 2)
      if (energy(w + length * step) <= start + 1e-4 * length * slope) break;
    w += length * step;
  }
  factor_.expand(w, direction);
  return direction;
}

}  // namespace palpate::fem
