// The first step of an equilibrium: contact and friction solved on the factor's own tangent,
// condensed to the nodes near the probe.

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "libfem/solve/equilibrium/equilibrium.hpp"

namespace palpate::fem {

// Contact terms on the dense block of the factor: stiffness (all entries) and force.
Eigen::MatrixXd Equilibrium::condensed_contact(Eigen::VectorXd& force) const {
  const auto size = static_cast<Eigen::Index>(3 * factor_.contact_nodes().size());
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(size, size);
  force.setZero(size);
  for (const FaceTerms& face : contact_.terms()) {
    std::array<std::int32_t, kFaceNodes> at;
    for (int a = 0; a < kFaceNodes; ++a) {
      const std::int32_t i = body_.free_index()[mesh_.faces(face.face, a)];
      at[a] = i < 0 ? -1 : 3 * contact_index_[i];
    }
    for (int a = 0; a < kFaceNodes; ++a) {
      if (at[a] < 0) continue;
      force.segment<3>(at[a]) += Eigen::Map<const Vec3>(face.force + 3 * a);
      for (int b = 0; b <= a; ++b) {
        if (at[b] < 0) continue;
        using Block = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;
        const int block = 9 * (a * (a + 1) / 2 + b);
        C.block<3, 3>(at[a], at[b]) += Block(face.stiffness + block);
        if (a != b) C.block<3, 3>(at[b], at[a]) += Block(face.stiffness + block);  // symmetric
      }
    }
  }
  return C;
}

bool Equilibrium::use_contact_stiffness() {
  Eigen::VectorXd force;
  return factor_.set_contact(condensed_contact(force));
}

// Puts the contact stiffness on the dense block: as it is, else without the curvature of the probe,
// else with ever stiffer springs on all contact nodes.
bool Equilibrium::set_contact_or_stiffer(const Eigen::MatrixXd& C, const ContactTrial& trial) {
  if (factor_.set_contact(C)) return true;
  Eigen::VectorXd force;
  contact_.evaluate(trial, false);
  Eigen::MatrixXd stiffer = condensed_contact(force);
  if (factor_.set_contact(stiffer)) return true;
  const double unit = factor_.schur().diagonal().cwiseAbs().maxCoeff();
  for (const double springs : {0.03, 0.3, 3.0}) {
    stiffer.diagonal().array() += springs * unit;
    if (factor_.set_contact(stiffer)) return true;
  }
  return false;
}

// The step to where a body with the factor's tangent would rest: contact and friction solved on the
// dense block by Newton's method, everything else follows linearly.
std::optional<Eigen::VectorXd> Equilibrium::model_direction(const Step& now) {
  const Local& at = now.at;
  const auto& nodes = factor_.contact_nodes();
  if (nodes.empty() || !factor_.is_factored()) return std::nullopt;
  Eigen::VectorXd elastic(K_.size()), load, w, Sw, Sstep, force, step;
  std::vector<Eigen::Index> node_of(nodes.size());
  for (Eigen::Index n = 0; n < at.u.rows(); ++n) {
    const std::int32_t i = body_.free_index()[n];
    if (i < 0) continue;
    elastic.segment<3>(3 * i) = -at.elastic_force.row(n).transpose();
    if (contact_index_[i] >= 0) node_of[contact_index_[i]] = n;
  }
  factor_.reduce(elastic, load);
  w.setZero(load.size()), Sw.setZero(load.size());
  Points u = at.u;
  const ContactTrial trial{u, now.pose, now.from.history};
  const auto place = [&](const Eigen::VectorXd& displacement, Points& out) {
    for (std::size_t i = 0; i < nodes.size(); ++i)
      out.row(node_of[i]) = at.u.row(node_of[i]) + displacement.segment<3>(3 * i).transpose();
  };
  const auto model_energy = [&](double length) {
    const Eigen::VectorXd displacement = w + length * step;
    place(displacement, u);
    return displacement.dot(0.5 * (Sw + length * Sstep) - load) + contact_.energy(trial);
  };
  int round = 0;
  for (int iteration = 0; iteration < options_.max_model; ++iteration) {
    contact_.evaluate(trial);
    const Eigen::MatrixXd C = condensed_contact(force);
    const Eigen::VectorXd residual = load - Sw - force;
    if (residual.norm() <= options_.model * force.norm()) {
      if (++round > 3) break;
      const double change = contact_.lag_friction_limit(trial);
      if (change < 0.02) break;
      continue;
    }
    ++counts_.model;
    if (!set_contact_or_stiffer(C, trial)) return std::nullopt;
    factor_.solve_contact(residual, step);
    Sstep.noalias() = factor_.schur() * step;  // S is read once: it outgrows the caches
    const double start = model_energy(0), slope = -residual.dot(step);
    double length = 1;
    for (int cut = 0; cut < 8; ++cut, length /= 2)
      if (model_energy(length) <= start + 1e-4 * length * slope) break;
    w += length * step;
    Sw += length * Sstep;
    place(w, u);
  }
  Eigen::VectorXd direction;
  factor_.expand(w, direction);
  return direction;
}

}  // namespace palpate::fem
