#include "libfem/solve/equilibrium.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

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
      model_(mesh, body_, contact_, factor_) {
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

double Equilibrium::energy(const Points& u, const ProbePose& pose,
                           const ContactHistory& history) const {
  const double elastic = body_.energy(u);
  return std::isfinite(elastic) ? elastic + contact_.energy(u, pose, history) : elastic;
}

// The guess, drawn back towards the last state until no element is inside out, or that state itself
// when its energy is less.
Points Equilibrium::start_of_search(const BodyState& from, const ProbePose& pose,
                                    const Points& guess) const {
  Points u = guess;
  for (int halving = 0; halving < 3 && !std::isfinite(body_.energy(u)); ++halving)
    u = (u + from.u) / 2;
  return energy(u, pose, from.history) < energy(from.u, pose, from.history) ? u : from.u;
}

void Equilibrium::assemble_elastic(double bend, Local& at) {
  at.elastic_force = Points::Zero(at.u.rows(), 3);
  K_.set_zero();
  body_.add_stiffness(at.u, bend, at.elastic_force, K_);
}

// Adds the contact stiffness to K_ and forms the residual.
void Equilibrium::add_contact(const BodyState& from, Local& at, BodyState& to) {
  to.contact = contact_.evaluate(at.u, to.pose, from.history);
  Points contact_force = Points::Zero(at.u.rows(), 3);
  for (const FaceTerms& face : contact_.terms()) {
    for (int a = 0; a < kFaceNodes; ++a)
      for (int i = 0; i < 3; ++i) contact_force(mesh_.faces(face.face, a), i) += face.force[3 * a + i];
    for (int block = 0; block < kFaceBlocks; ++block)
      K_.add(face_places_[kFaceBlocks * face.face + block], face.stiffness + 9 * block);
  }
  at.residual.resize(K_.size());
  double contact_squared = 0;
  for (Eigen::Index n = 0; n < at.u.rows(); ++n) {
    const std::int32_t i = body_.free_index()[n];
    if (i < 0) continue;
    at.residual.segment<3>(3 * i) = -(at.elastic_force.row(n) + contact_force.row(n)).transpose();
    contact_squared += contact_force.row(n).squaredNorm();
  }
  // A body that the probe leaves springs back; what it was pressed with then sets the scale.
  to.contact_scale_N = std::max(std::sqrt(contact_squared), 1e-2 * from.contact_scale_N);
  to.relative_residual = at.residual.norm() / to.contact_scale_N;
}

void Equilibrium::linearise(const BodyState& from, Local& at, BodyState& to) {
  assemble_elastic(1.0, at);
  to.least_J = body_.least_J();
  add_contact(from, at, to);
}

// Free nodes of faces that come within a distance of the probe.
std::vector<std::int32_t> Equilibrium::nodes_near_probe(const Points& u, const ProbePose& pose,
                                                        double within_m) const {
  std::vector<std::int32_t> nodes;
  for (const int face : contact_.faces_near(u, pose, within_m))
    for (int a = 0; a < kFaceNodes; ++a)
      if (const std::int32_t i = body_.free_index()[mesh_.faces(face, a)]; i >= 0) nodes.push_back(i);
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

// Factors the elastic tangent at `at`, and linearises there; where it is not positive definite, with
// ever less of the part that carries the second derivative of J. The level that worked is remembered.
void Equilibrium::refresh_factor(const BodyState& from, Local& at, BodyState& to) {
  const auto nodes = nodes_near_probe(at.u, to.pose, options_.contact_margin * step_m_);
  for (;;) {
    assemble_elastic(bend_, at);
    to.least_J = body_.least_J();
    ++counts_.factorizations;
    if (!(to.least_J > 0) || factor_.factor(K_, nodes)) break;
    ++counts_.failed_factorizations;
    if (bend_ <= 0) break;
    bend_ = bend_ > 0.5 ? 0.5 : 0.0;
  }
  model_.settle();
  if (bend_ < 1) assemble_elastic(1.0, at);
  add_contact(from, at, to);
}

// To where the condensed model rests. False when that is no progress.
bool Equilibrium::step_by_model(const BodyState& from, const ProbePose& pose, bool is_first,
                                Local& at) {
  std::optional<Points> stuck;
  if (is_first) stuck = from.u.rowwise() + (pose.tip - from.pose.tip).transpose();
  const std::optional<Eigen::VectorXd> direction = model_.solve(
      at.u, at.elastic_force, pose, from.history, stuck, options_.model, counts_.model);
  return direction && search_line(*direction, 0.0, pose, from.history, at.u);
}

// To where the current tangent says; a factor that costs too many iterations is refreshed.
bool Equilibrium::step_by_newton(const BodyState& from, Local& at, BodyState& to) {
  const auto multiply = [this](const Eigen::VectorXd& x, Eigen::VectorXd& y) { K_.multiply(x, y); };
  const auto precondition = [this](const Eigen::VectorXd& b, Eigen::VectorXd& x) {
    factor_.solve(b, x);
  };
  Eigen::VectorXd direction;
  for (const bool is_fresh : {false, true}) {
    if (is_fresh) refresh_factor(from, at, to);
    if (!factor_.is_factored()) continue;
    model_.use_contact_stiffness(at.u, to.pose, from.history);
    const PcgOutcome outcome =
        pcg(multiply, precondition, at.residual, direction, options_.linear, options_.most_pcg);
    counts_.pcg += outcome.iterations;
    if (outcome.relative_residual <= options_.linear) break;
  }
  // No positive definite tangent at any level: descend along the scaled residual.
  if (!factor_.is_factored()) direction = at.residual.cwiseQuotient(K_.diagonal().cwiseAbs());
  return search_line(direction, -at.residual.dot(direction), to.pose, from.history, at.u);
}

// Backtracks from a full step until the incremental energy falls enough (Armijo). Near the solution
// the fall drowns in rounding, and a full step that leaves the energy level is taken.
bool Equilibrium::search_line(const Eigen::VectorXd& direction, double slope, const ProbePose& pose,
                              const ContactHistory& history, Points& u) {
  constexpr double kSufficient = 1e-4, kRounding = 1e-9;
  const double start = energy(u, pose, history);
  double length = 1;
  for (int cut = 0; cut < 8; ++cut, length /= 2) {
    const Points trial = moved(u, direction, length);
    const double there = energy(trial, pose, history);
    if (there <= start + kSufficient * length * slope + kRounding * std::abs(start)) {
      u = trial;
      return true;
    }
    ++counts_.backtracks;
  }
  return false;
}

SolveStatus Equilibrium::solve(const BodyState& from, const ProbePose& pose, const Points& guess,
                               BodyState& to) {
  contact_.hold_friction_limit(from.history);
  Local at;
  at.u = start_of_search(from, pose, guess);
  to.pose = pose;
  step_m_ = (pose.tip - from.pose.tip).norm();
  const int pcg_before = counts_.pcg;
  double least_residual = std::numeric_limits<double>::infinity();
  bool came_by_model = false, is_fresh = is_stale_;
  for (int iteration = 0; iteration < options_.most_newton; ++iteration) {
    if (iteration > 0) contact_.hold_friction_limit(at.u, pose, from.history);
    if (is_stale_) refresh_factor(from, at, to); else linearise(from, at, to);
    is_stale_ = false;
    if (!(to.least_J > 0)) return SolveStatus::inverted;
    if (to.relative_residual <= options_.residual) {
      is_stale_ = counts_.pcg - pcg_before > options_.stale_pcg;
      to.u = at.u;
      to.history = contact_.accepted(at.u, pose, from.history);
      return SolveStatus::solved;
    }
    const double hopeless = iteration == 1 ? options_.hopeless_at_first : options_.hopeless;
    if (iteration >= 1 && to.relative_residual > hopeless) break;
    ++counts_.newton;
    const bool is_poor = (came_by_model && to.relative_residual > options_.trusted) ||
                         to.relative_residual > options_.contraction * least_residual;
    const bool must_refresh = iteration > 0 && is_poor && !is_fresh;
    if (must_refresh) refresh_factor(from, at, to);
    is_fresh = must_refresh;
    if (iteration > 0) least_residual = std::min(least_residual, to.relative_residual);
    came_by_model = (must_refresh || !came_by_model) &&
                    step_by_model(from, pose, iteration == 0, at);
    if (came_by_model) continue;
    // The model may have left another friction limit.
    if (iteration > 0) contact_.hold_friction_limit(at.u, pose, from.history);
    linearise(from, at, to);
    if (!step_by_newton(from, at, to)) break;
  }
  is_stale_ = true;
  to.u = at.u;
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
