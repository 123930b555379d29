#include "libfem/solve/equilibrium/equilibrium.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "libfem/mesh/topology.hpp"
#include "libfit/core/linear_algebra.hpp"

namespace palpate::fem {
namespace {

/// Small-strain modulus under each face, of the material at its centre.
std::vector<double> face_young(const QuadraticMesh& mesh, const std::vector<Material>& materials,
                               const RegionAt& region_at) {
  std::vector<double> young(mesh.faces.rows());
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f) {
    Vec3 centre = Vec3::Zero();
    for (int a = 3; a < 6; ++a) centre += mesh.nodes.row(mesh.faces(f, a)).transpose() / 3;
    const Material& here = materials.at(region_at ? region_at(centre) : 0);
    young[f] = here.law->small_strain(here.constants).young_Pa();
  }
  return young;
}

// A factor of a body that was this much stiffer or softer is made anew at once.
constexpr double kStiffnessChange = 1.25;

}  // namespace

Eigen::VectorXd AndersonMixing::mix(const Eigen::VectorXd& d, const Eigen::VectorXd& b) {
  if (previous_.motion.size() > 0) {
    if (pairs_.size() >= depth_ && !pairs_.empty()) pairs_.erase(pairs_.begin());
    if (depth_ > 0) pairs_.push_back({previous_.motion, d - previous_.step, b - previous_.load});
  }
  previous_ = {{}, d, b};
  const Eigen::Index count = std::ssize(pairs_);
  if (count == 0) return d;
  Eigen::MatrixXd gram(count, count);
  Eigen::VectorXd right(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    right[i] = pairs_[i].step.dot(b);
    for (Eigen::Index j = 0; j <= i; ++j)
      gram(i, j) = gram(j, i) = pairs_[i].step.dot(pairs_[j].load);
  }
  gram.diagonal().array() *= 1 + 1e-9;  // against rounding where pairs are parallel
  const Eigen::VectorXd share = ldlt_solve(gram, right);
  if (!share.allFinite()) return d;
  Eigen::VectorXd out = d;
  for (Eigen::Index i = 0; i < count; ++i) out -= share[i] * (pairs_[i].motion + pairs_[i].step);
  return out;
}

Equilibrium::Equilibrium(const QuadraticMesh& mesh, const std::vector<Material>& materials,
                         const RegionAt& region_at, const Probe& probe,
                         const ContactSettings& contact, const EquilibriumOptions& options,
                         const BoundaryLoads& loads)
    : mesh_(mesh),
      options_(options),
      body_(mesh, materials, region_at),
      bed_(mesh, loads.bed_at),
      lumen_(mesh, loads.lumen_pressure_Pa),
      contact_(mesh.nodes, mesh.faces, mesh.is_held, face_young(mesh, materials, region_at), probe,
               contact),
      K_(body_.pattern()) {
  // By nested dissection a factor of n nodes takes n^2 and a correction n^(4/3). Presses on 9,100
  // nodes take 3.0 s with the counts of 4,000 nodes, 2.4 s with one and a half times and twice
  // them.
  const double dearer = std::max(1.0, std::pow(mesh.nodes.rows() / 4000.0, 2.0 / 3));
  options_.patience = static_cast<int>(options_.patience * dearer);
  options_.stale = static_cast<int>(options_.stale * dearer);
  balance_pressure(mesh, loads, body_);
}

BodyState Equilibrium::rest(const ProbePose& pose) const {
  BodyState state;
  state.u = Points::Zero(mesh_.nodes.rows(), 3);
  state.pose = pose;
  state.history = contact_.untouched(pose);
  if (lumen_.is_empty()) return state;
  Points force = state.u;
  state.elastic_energy_J = body_.energy(state.u) + lumen_.add_force(state.u, force);
  if (body_.relaxes() || body_.softens())
    state.memory = std::make_shared<const MaterialHistory>(body_.remembered(
        state.u, body_.step_from(nullptr, std::numeric_limits<double>::infinity())));
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

// Tangent, forces and energy of the body at at.u.
void Equilibrium::assemble_elastic(double geometric_scale, double max_pressure, Local& at) {
  at.elastic_force = Points::Zero(at.u.rows(), 3);
  K_.set_zero();
  at.elastic_energy_J =
      body_.add_stiffness(at.u, geometric_scale, at.elastic_force, K_, max_pressure) +
      bed_.add_force(at.u, at.elastic_force) + lumen_.add_force(at.u, at.elastic_force);
  bed_.add_stiffness(body_.free_index(), K_);
  lumen_.add_stiffness(at.u, body_.free_index(), K_);
}

// Contact terms, energy and residual from the elastic ones; the friction limit is lagged.
void Equilibrium::add_contact(Step& step) {
  Local& at = step.at;
  step.to.contact = contact_.evaluate(step.trial());
  at.energy_J = at.elastic_energy_J + step.to.contact.energy_J;
  Points contact_force = Points::Zero(at.u.rows(), 3);
  for (const FaceTerms& face : contact_.terms())
    for (int a = 0; a < kFaceNodes; ++a)
      for (int i = 0; i < 3; ++i)
        contact_force(mesh_.faces(face.face, a), i) += face.force[3 * a + i];
  at.residual.resize(K_.size());
  double contact_squared = 0;
  for (Eigen::Index n = 0; n < at.u.rows(); ++n) {
    const std::int32_t i = body_.free_index()[n];
    if (i < 0) continue;
    at.residual.segment<3>(3 * i) = -(at.elastic_force.row(n) + contact_force.row(n)).transpose();
    contact_squared += contact_force.row(n).squaredNorm();
  }
  at.contact_scale_N = std::sqrt(contact_squared);
  // Residuals of a body that springs back after a tool has left it are compared with this share of
  // the largest contact force.
  if (step_) at.contact_scale_N = std::max(at.contact_scale_N, 0.01 * step.from.largest_contact_N);
}

// Forces and energy at step.at.u; no stiffness, which costs ten times as much.
void Equilibrium::evaluate(Step& step) {
  Local& at = step.at;
  at.elastic_force = Points::Zero(at.u.rows(), 3);
  at.elastic_energy_J = body_.add_force(at.u, at.elastic_force) +
                        bed_.add_force(at.u, at.elastic_force) +
                        lumen_.add_force(at.u, at.elastic_force);
  step.to.min_J = body_.min_J();
  add_contact(step);
}

// Free nodes of faces that come within a distance of the probe or touch it.
std::vector<std::int32_t> Equilibrium::nodes_near_probe(const Points& u, const ProbePose& pose,
                                                        double within_m) const {
  std::vector<std::int32_t> nodes;
  const auto add_face = [&](int face) {
    for (int a = 0; a < kFaceNodes; ++a)
      if (const std::int32_t i = body_.free_index()[mesh_.faces(face, a)]; i >= 0)
        nodes.push_back(i);
  };
  for (const int face : contact_.faces_near(u, pose, within_m)) add_face(face);
  for (const FaceTerms& face : contact_.terms()) add_face(face.face);
  sort_unique(nodes);
  return nodes;
}

void Equilibrium::index_contact_nodes() {
  contact_index_.assign(K_.nodes(), -1);
  for (std::size_t i = 0; i < factor_.contact_nodes().size(); ++i)
    contact_index_[factor_.contact_nodes()[i]] = static_cast<std::int32_t>(i);
}

// Factors the elastic tangent; where it is not positive definite, with ever less of its geometric
// part, which carries the second derivative of J. The scale that worked is remembered.
void Equilibrium::refresh_factor(Step& step) {
  Local& at = step.at;
  const auto nodes = nodes_near_probe(at.u, step.pose, step_m_);
  for (;;) {
    assemble_elastic(geometric_scale_, 2, at);  // shear moduli: see ElasticBody::add_stiffness
    ++counts_.factorizations;
    if (factor_.factor(K_, nodes)) break;
    if (geometric_scale_ <= 0) break;
    geometric_scale_ = geometric_scale_ > 0.5 ? 0.5 : 0.0;
  }
  if (step_) factored_stiffening_ = step_->max_stiffening();
  index_contact_nodes();
  tangent_.clear();
  step.to.min_J = body_.min_J();
  add_contact(step);
}

// Place of a node of a face among the contact nodes of the factor; -1 elsewhere, -2 for held nodes.
std::int32_t Equilibrium::contact_place(int face, int node) const {
  const std::int32_t i = body_.free_index()[mesh_.faces(face, node)];
  return i < 0 ? -2 : contact_index_[i];
}

// True if the probe presses on a node outside the dense block.
bool Equilibrium::touches_elsewhere() const {
  return std::ranges::any_of(contact_.terms(), [&](const FaceTerms& terms) {
    for (int a = 0; a < kFaceNodes; ++a)
      if (contact_place(terms.face, a) == -1) return true;
    return false;
  });
}

// Backtracks from a full step until the incremental energy falls enough (Armijo), and moves there.
// Near the solution the fall drowns in rounding, and a full step that leaves the energy level is
// taken. Returns the share of `direction` that was gone, 0 when `tries` were in vain. Forces come
// with the energy of a trial for a fifth more, and the accepted one's are kept.
double Equilibrium::search_line(const Eigen::VectorXd& direction, int tries, Step& step) {
  Local& at = step.at;
  const double slope = std::min(0.0, -at.residual.dot(direction));
  double length = 1;
  for (int cut = 0; cut < tries; ++cut, length /= 2) {
    Step trial{step.from, step.pose, step.to};
    trial.at.u = moved(at.u, direction, length);
    evaluate(trial);
    if (trial.at.energy_J <= at.energy_J + 1e-4 * length * slope + 1e-13 * std::abs(at.energy_J)) {
      at = std::move(trial.at);
      contact_.lag_friction_limit(step.trial());
      add_contact(step);
      return length;
    }
  }
  return 0;
}

// Goes on by a correction, combined with those before it where that lowers the energy, else by the
// correction alone. False when neither does.
bool Equilibrium::take(const Correction& correction, AndersonMixing& mixing, Step& step) {
  add_contact(step);  // for the friction limit that the correction has found
  const Eigen::VectorXd mixed = mixing.mix(correction.displacement, correction.load);
  double length = search_line(mixed, 1, step);
  if (length > 0) {
    mixing.record(mixed);
    return true;
  }
  length = search_line(correction.displacement, 12, step);
  mixing.record(length * correction.displacement);
  return length > 0;
}

// Takes the guess, drawn towards the state it comes from until its energy is finite and no larger
// than there.
void Equilibrium::start(Step& step, const Points& guess) {
  const BodyState& from = step.from;
  Local& at = step.at;
  contact_.lag_friction_limit(from.history);
  at.u = guess;
  evaluate(step);
  for (int halving = 0; halving < 3 && !std::isfinite(at.energy_J); ++halving) {
    at.u = halving < 2 ? Points((at.u + from.u) / 2) : from.u;
    evaluate(step);
  }
  if (elastic_energy_J(from) + contact_.energy({from.u, step.pose, from.history}) < at.energy_J) {
    at.u = from.u;
    evaluate(step);
  }
}

bool Equilibrium::solve(const BodyState& from, const ProbePose& pose, const Points& guess,
                        BodyState& to, bool may_shorten) {
  Step step{from, pose, to};
  const Local& at = step.at;
  start(step, guess);
  to.pose = pose;
  double moved_m = (pose.tip - from.pose.tip).norm();
  if (pose.second) moved_m = std::max(moved_m, (pose.second->tip - from.pose.second->tip).norm());
  if (moved_m > 0) step_m_ = moved_m;
  AndersonMixing mixing(options_.mixing);
  int since_factor = 0;
  bool is_in_vain = is_stale_;
  for (int iteration = 0; iteration < options_.max_newton; ++iteration) {
    if (!factor_.is_factored() || is_in_vain || since_factor >= options_.patience ||
        touches_elsewhere()) {
      refresh_factor(step);
      if (!factor_.is_factored()) break;
      mixing.reset();
      since_factor = 0;
      is_stale_ = is_in_vain = false;
    }
    to.relative_residual = at.residual.norm() / at.contact_scale_N;
    if (at.residual.norm() <= options_.residual * at.contact_scale_N) {
      is_stale_ = since_factor > options_.stale;
      to.u = at.u;
      to.elastic_energy_J = at.elastic_energy_J;
      to.history = contact_.accepted(step.trial());
      to.largest_contact_N = std::max(from.largest_contact_N, at.contact_scale_N);
      return true;
    }
    if (may_shorten && iteration >= options_.max_astray && to.relative_residual > 0.3) break;
    ++counts_.newton;
    const double residual_before = at.residual.norm();
    const bool is_taken = take(correction(step), mixing, step);
    if (!is_taken && since_factor == 0) break;
    ++since_factor;
    // A correction that doubles the residual calls for a new factor.
    is_in_vain = !is_taken || (iteration > 0 && at.residual.norm() > 2 * residual_before);
  }
  to.u = at.u;
  return false;
}

void Equilibrium::resume(std::shared_ptr<const MaterialStep> step) {
  step_ = std::move(step);
  body_.set_step(step_);
  const double ratio = step_->max_stiffening() / factored_stiffening_;
  if (ratio > kStiffnessChange || ratio < 1 / kStiffnessChange) is_stale_ = true;
}

void Equilibrium::begin_step(const BodyState& from, double dt_s) {
  if (!body_.relaxes() && !body_.softens()) return;
  resume(std::make_shared<const MaterialStep>(body_.step_from(from.memory, dt_s)));
}

void Equilibrium::end_step(const Points& u, BodyState& accepted) const {
  if (!step_) return;
  accepted.step = step_;
  accepted.memory = std::make_shared<const MaterialHistory>(body_.remembered(u, *step_));
}

// An accepted state's energy in the potential of this step.
double Equilibrium::elastic_energy_J(const BodyState& from) const {
  if (!step_) return from.elastic_energy_J;
  Points force = Points::Zero(from.u.rows(), 3);
  return body_.energy(from.u) + bed_.add_force(from.u, force) + lumen_.add_force(from.u, force);
}

bool Equilibrium::uzawa_update(const BodyState& accepted, BodyState& to) {
  if (accepted.step) resume(accepted.step);
  BodyState from = accepted;
  from.history = contact_.updated_multipliers(accepted.history);
  return solve(from, accepted.pose, accepted.u, to);
}

bool Equilibrium::is_stable(const BodyState& accepted) {
  BodyState here;
  Step step{accepted, accepted.pose, here};
  step.at.u = accepted.u;
  assemble_elastic(1.0, std::numeric_limits<double>::infinity(), step.at);
  ++counts_.factorizations;
  is_stale_ = true;  // made without bounds that Newton's method likes
  if (!factor_.factor(K_, nodes_near_probe(accepted.u, accepted.pose, step_m_))) return false;
  index_contact_nodes();
  contact_.lag_friction_limit(accepted.history);
  add_contact(step);
  std::vector<Eigen::Index> all(factor_.schur().rows());
  std::iota(all.begin(), all.end(), 0);
  return factor_.is_stable_with(condensed_stiffness(all));
}

}  // namespace palpate::fem
