// One correction of an equilibrium: contact and friction solved on the factor's own tangent,
// condensed to the nodes near the probe.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <vector>

#include "libfem/solve/equilibrium/equilibrium.hpp"

namespace palpate::fem {
namespace {

// A tangent of an earlier place serves for as long as a step with it brings the residual down to
// this share: a step with a fresh one costs as much as five.
constexpr double kKeptTangent = 0.6;
// A step of coupled friction that leaves this share of the residual has met its match.
constexpr double kInVain = 0.98;

}  // namespace

// Force of the latest contact terms over the dense block.
Eigen::VectorXd Equilibrium::condensed_force() const {
  Eigen::VectorXd force =
      Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * factor_.contact_nodes().size()));
  for (const FaceTerms& face : contact_.terms())
    for (int a = 0; a < kFaceNodes; ++a) {
      const std::int32_t i = body_.free_index()[mesh_.faces(face.face, a)];
      if (i >= 0 && contact_index_[i] >= 0)
        force.segment<3>(3 * contact_index_[i]) += Eigen::Map<const Vec3>(face.force + 3 * a);
    }
  return force;
}

// Unknowns of the dense block on faces of the latest contact terms, increasing.
std::vector<Eigen::Index> Equilibrium::touching_unknowns() const {
  std::vector<Eigen::Index> out;
  for (const FaceTerms& face : contact_.terms())
    for (int a = 0; a < kFaceNodes; ++a) {
      const std::int32_t i = body_.free_index()[mesh_.faces(face.face, a)];
      if (i < 0 || contact_index_[i] < 0) continue;
      for (int c = 0; c < 3; ++c) out.push_back(3 * contact_index_[i] + c);
    }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

// Stiffness of the latest contact terms on some unknowns of the dense block, all entries.
Eigen::MatrixXd Equilibrium::condensed_stiffness(const std::vector<Eigen::Index>& unknowns) const {
  std::vector<std::int32_t> place(3 * factor_.contact_nodes().size(), -1);
  for (std::size_t k = 0; k < unknowns.size(); ++k)
    place[unknowns[k]] = static_cast<std::int32_t>(k);
  const auto size = static_cast<Eigen::Index>(unknowns.size());
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(size, size);
  using Block = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;
  for (const FaceTerms& face : contact_.terms()) {
    std::array<std::int32_t, kFaceNodes> at;
    for (int a = 0; a < kFaceNodes; ++a) {
      const std::int32_t i = body_.free_index()[mesh_.faces(face.face, a)];
      at[a] = i < 0 || contact_index_[i] < 0 ? -1 : place[3 * contact_index_[i]];
    }
    for (int a = 0; a < kFaceNodes; ++a)
      for (int b = 0; b <= a && at[a] >= 0; ++b) {
        if (at[b] < 0) continue;
        const Block block(face.stiffness + 9 * (a * (a + 1) / 2 + b));
        C.block<3, 3>(at[a], at[b]) += block;
        if (a != b) C.block<3, 3>(at[b], at[a]) += block;
      }
  }
  return C;
}

// The correction after which a body with the factor's tangent would rest: contact solved on the
// dense block by Newton's method with friction coupled, all else follows linearly. Where that
// stalls, friction is lagged until a descent in energy has come close.
Equilibrium::Correction Equilibrium::correction(const Step& now) {
  const Local& at = now.at;
  const auto& nodes = factor_.contact_nodes();
  const Eigen::MatrixXf& flexibility = factor_.flexibility();
  Correction out;
  std::vector<Eigen::Index> node_of(nodes.size());
  for (Eigen::Index n = 0; n < at.u.rows(); ++n)
    if (const std::int32_t i = body_.free_index()[n]; i >= 0 && contact_index_[i] >= 0)
      node_of[contact_index_[i]] = n;
  // Contact forces are added behind the reduction, whose single precision small residuals survive.
  Eigen::VectorXd load, residual;
  factor_.reduce(at.residual, load);
  const Eigen::VectorXd force_before = condensed_force();
  load += force_before;
  CondensedTangent::CondensedStep sum{Eigen::VectorXd::Zero(load.size()), load};
  Points u = at.u;
  const ContactTrial trial{u, now.pose, now.from.history};
  bool is_coupled = true;
  const auto go = [&](const CondensedTangent::CondensedStep& step, double length) {
    sum.w += length * step.w;
    sum.z += length * step.z;
    for (std::size_t i = 0; i < nodes.size(); ++i)
      u.row(node_of[i]) = at.u.row(node_of[i]) + sum.w.segment<3>(3 * i).transpose();
  };
  // Relative size of the residual z - f(w); 0 where nothing touches and nothing is exerted.
  const auto evaluate = [&](bool with_curvature = true) {
    if (is_coupled)
      contact_.evaluate_coupled(trial);
    else
      contact_.evaluate(trial, with_curvature);
    const Eigen::VectorXd force = condensed_force();
    residual = sum.z - force;
    return residual.norm() > 0 ? residual.norm() / force.norm() : 0;
  };
  const auto refactor = [&] {
    tangent_.cover(flexibility, touching_unknowns());
    tangent_.set_contact(condensed_stiffness(tangent_.unknowns()));
    ++counts_.model_factors;
  };
  const auto energy = [&] { return -0.5 * sum.w.dot(load + sum.z) + contact_.energy(trial); };
  // Halves a step until the energy for the lagged limit falls.
  const auto falls = [&](const CondensedTangent::CondensedStep& step) {
    const double start = energy(), slope = -residual.dot(step.w);
    if (!(slope < 0)) return false;
    double length = 1;
    go(step, 1);
    for (int cut = 0; cut < 8; ++cut, length /= 2) {
      if (energy() <= start + 1e-4 * length * slope) return true;
      go(step, -length / 2);
    }
    go(step, -length);
    return false;
  };
  const auto descend = [&] {
    refactor();
    if (falls(tangent_.step(flexibility, residual))) return evaluate();
    evaluate(false);
    refactor();
    const CondensedTangent::CondensedStep step = tangent_.step(flexibility, residual);
    if (!falls(step)) go(step, 1.0 / 256);
    return evaluate();
  };
  const double goal =
      options_.model * std::max(options_.residual, at.residual.norm() / at.contact_scale_N);
  double relative = evaluate();
  bool is_kept = !tangent_.is_empty();
  for (int iteration = 0; iteration < options_.max_model; ++iteration) {
    if (is_coupled && relative <= goal) break;
    ++counts_.model;
    if (!is_coupled) {
      relative = descend();
      if (relative > options_.model_lagged) continue;
      contact_.lag_friction_limit(trial);
      is_coupled = true;
      is_kept = false;
      relative = evaluate();
      continue;
    }
    if (!is_kept) refactor();
    const CondensedTangent::CondensedStep step = tangent_.step(flexibility, residual);
    const double before = relative;
    double length = 1;
    go(step, 1);
    relative = evaluate();
    if (is_kept && relative > kKeptTangent * before) {
      go(step, -1);
      relative = evaluate();
      is_kept = false;
      continue;
    }
    for (int cut = 0; cut < 4 && relative > (1 - 0.1 * length) * before; ++cut, length /= 2) {
      go(step, -length / 2);
      relative = evaluate();
    }
    is_kept = relative <= kKeptTangent * before;
    if (relative <= kInVain * before) continue;
    contact_.lag_friction_limit(trial);
    is_coupled = false;
    relative = evaluate();
  }
  contact_.lag_friction_limit(trial);
  out.load = at.residual;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    out.load.segment<3>(3 * nodes[i]) += (force_before - sum.z).segment<3>(3 * i);
  factor_.expand(sum.w, out.displacement);
  return out;
}

}  // namespace palpate::fem
