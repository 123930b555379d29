#include "libfem/solve/equilibrium.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "libfem/solve/pcg.hpp"

namespace palpate::fem {
namespace {

std::vector<double> face_young(const QuadraticMesh& mesh, const std::vector<Material>& materials,
                               const RegionAt& region_at) {
  std::vector<double> young(mesh.faces.rows());
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f) {
    Vec3 centre = Vec3::Zero();
    for (int a = 3; a < 6; ++a) centre += mesh.nodes.row(mesh.faces(f, a)).transpose() / 3;
    const Material& here = materials.at(region_at ? static_cast<std::size_t>(region_at(centre)) : 0);
    young[f] = here.law->small_strain(here.constants).young_Pa();
  }
  return young;
}

}  // namespace

Equilibrium::Equilibrium(const QuadraticMesh& mesh, const std::vector<Material>& materials,
                         const RegionAt& region_at, const Probe& probe,
                         const ContactSettings& contact, const EquilibriumOptions& options)
    : mesh_(mesh),
      options_(options),
      body_(mesh, materials, region_at),
      contact_(mesh.nodes, mesh.faces, mesh.is_held, face_young(mesh, materials, region_at), probe,
               contact),
      K_(body_.pattern()),
      factor_(K_) {
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
    for (int a = 0; a < kFaceNodes; ++a)
      for (int b = 0; b <= a; ++b)
        face_places_.push_back(K_.place(body_.free_index()[mesh.faces(f, a)],
                                        body_.free_index()[mesh.faces(f, b)]));
}

BodyState Equilibrium::rest(const ProbePose& pose) const {
  BodyState state;
  state.u = Points::Zero(mesh_.nodes.rows(), 3);
  state.pose = pose;
  state.history = contact_.untouched(pose);
  return state;
}

Points Equilibrium::moved(const Points& u, const Eigen::VectorXd& direction, double length) const {
  Points out = u;
  for (Eigen::Index n = 0; n < u.rows(); ++n) {
    const std::int32_t i = body_.free_index()[n];
    if (i >= 0) out.row(n) += length * direction.segment<3>(3 * i).transpose();
  }
  return out;
}

// Fills K_ and residual_ (out-of-balance force, pointing where the body wants to go); returns energy.
double Equilibrium::assemble(const Points& u, const ProbePose& pose, const ContactHistory& history,
                             double bend, BodyState& to) {
  Points gradient = Points::Zero(u.rows(), 3), contact_force = gradient;
  K_.set_zero();
  const double elastic = body_.add_stiffness(u, bend, gradient, K_);
  to.least_J = body_.least_J();
  to.contact = contact_.evaluate(u, pose, history);
  for (const FaceTerms& face : contact_.terms()) {
    for (int a = 0; a < kFaceNodes; ++a)
      for (int i = 0; i < 3; ++i) contact_force(mesh_.faces(face.face, a), i) += face.force[3 * a + i];
    for (int block = 0; block < kFaceBlocks; ++block)
      K_.add(face_places_[kFaceBlocks * face.face + block], face.stiffness + 9 * block);
  }
  residual_.resize(K_.size());
  double contact_squared = 0;
  for (Eigen::Index n = 0; n < u.rows(); ++n) {
    const std::int32_t i = body_.free_index()[n];
    if (i < 0) continue;
    residual_.segment<3>(3 * i) = -(gradient.row(n) + contact_force.row(n)).transpose();
    contact_squared += contact_force.row(n).squaredNorm();
  }
  contact_scale_N_ = std::sqrt(contact_squared);
  return elastic;
}

double Equilibrium::energy(const Points& u, const ProbePose& pose,
                           const ContactHistory& history) const {
  const double elastic = body_.energy(u);
  return std::isfinite(elastic) ? elastic + contact_.energy(u, pose, history) : elastic;
}

// Factors the tangent at u; where it is not positive definite, with ever less of the part that
// carries the second derivative of J. The level that worked is remembered.
void Equilibrium::refresh_factor(const Points& u, const ProbePose& pose, const BodyState& from,
                                 BodyState& to) {
  if (bend_ < 1) assemble(u, pose, from.history, bend_, to);
  while (++counts_.factorizations, !factor_.factor(K_)) {
    ++counts_.failed_factorizations;
    if (bend_ <= 0) break;
    bend_ = bend_ > 0.5 ? 0.5 : 0.0;
    assemble(u, pose, from.history, bend_, to);
  }
  if (bend_ < 1) assemble(u, pose, from.history, 1.0, to);
}

Eigen::VectorXd Equilibrium::newton_direction(const Points& u, const ProbePose& pose,
                                              const BodyState& from, BodyState& to) {
  const auto multiply = [this](const Eigen::VectorXd& x, Eigen::VectorXd& y) { K_.multiply(x, y); };
  const auto precondition = [this](const Eigen::VectorXd& b, Eigen::VectorXd& x) {
    factor_.solve(b, x);
  };
  Eigen::VectorXd direction;
  for (int attempt = 0; attempt < 2; ++attempt) {
    if (!factor_.is_factored() || attempt == 1) refresh_factor(u, pose, from, to);
    if (!factor_.is_factored()) break;
    const PcgOutcome outcome =
        pcg(multiply, precondition, residual_, direction, options_.linear, options_.most_pcg);
    counts_.pcg += outcome.iterations;
    if (outcome.relative_residual <= options_.linear) return direction;
    if (attempt == 1) return direction;
  }
  // No positive definite tangent at any level: descend along the scaled residual.
  return residual_.cwiseQuotient(K_.diagonal().cwiseAbs());
}

// Backtracks from a full step until the incremental energy falls enough (Armijo). Near the solution
// the fall drowns in rounding, and a full step that leaves the energy level is taken.
bool Equilibrium::search_line(const Eigen::VectorXd& direction, const ProbePose& pose,
                              const ContactHistory& history, Points& u) {
  constexpr double kSufficient = 1e-4, kRounding = 1e-13;
  const double start = energy(u, pose, history);
  const double slope = -residual_.dot(direction);
  double length = 1;
  for (int cut = 0; cut < 12; ++cut, length /= 2) {
    const Points trial = moved(u, direction, length);
    const double there = energy(trial, pose, history);
    static const bool free_ls = getenv("FREE");
    if ((free_ls && std::isfinite(there)) || there <= start + kSufficient * length * slope + kRounding * std::abs(start)) {
      u = trial;
      return true;
    }
    ++counts_.line_searches;
  }
  return false;
}

SolveStatus Equilibrium::solve(const BodyState& from, const ProbePose& pose, const Points& guess,
                               BodyState& to) {
  Points u = guess;
  for (int halving = 0; halving < 4 && !std::isfinite(body_.energy(u)); ++halving)
    u = halving < 3 ? Points((u + from.u) / 2) : from.u;
  to.pose = pose;
  double bend_reset = bend_;
  (void)bend_reset;
  for (int iteration = 0; iteration < options_.most_newton; ++iteration) {
    const double elastic = assemble(u, pose, from.history, 1.0, to);
    if (!std::isfinite(elastic)) return SolveStatus::inverted;
    to.relative_residual = residual_.norm() / contact_scale_N_;
    if (residual_.norm() <= options_.residual * contact_scale_N_) {
      to.u = u;
      to.history = contact_.accepted(u, pose, from.history);
      return SolveStatus::solved;
    }
    ++counts_.newton;
    if (getenv("DBG")) printf("   it %d res %.3e scale %.3e F %.5f pen %.5f pts %d J %.3f bend %.1f pcg %d fac %d(%d) ls %d\n",iteration,residual_.norm(),contact_scale_N_,to.contact.force_N.norm(),to.contact.greatest_penetration_m*1e3,to.contact.points,to.least_J,bend_,counts_.pcg,counts_.factorizations,counts_.failed_factorizations,counts_.line_searches);
    const Eigen::VectorXd direction = newton_direction(u, pose, from, to);
    if (!search_line(direction, pose, from.history, u)) break;
  }
  to.u = u;
  return SolveStatus::not_converged;
}

Vec3 Equilibrium::reaction_N(const Points& u) const {
  Points gradient = Points::Zero(u.rows(), 3);
  body_.add_force(u, gradient);
  Vec3 sum = Vec3::Zero();
  for (Eigen::Index n = 0; n < u.rows(); ++n)
    if (mesh_.is_held[n]) sum += gradient.row(n).transpose();
  return sum;
}

}  // namespace palpate::fem
