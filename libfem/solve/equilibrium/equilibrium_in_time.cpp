// Steps of a body that remembers (time, or the largest energies): each is an equilibrium in a
// potential of its own.

#include "libfem/solve/equilibrium/equilibrium.hpp"

namespace palpate::fem {
namespace {

// A factor of a body that was this much stiffer or softer is made anew at once.
constexpr double kOtherBody = 1.25;

}  // namespace

void Equilibrium::resume(std::shared_ptr<const MaterialStep> step) {
  step_ = std::move(step);
  body_.set_step(step_);
  const double ratio = step_->max_stiffening() / factored_stiffening_;
  if (ratio > kOtherBody || ratio < 1 / kOtherBody) is_stale_ = true;
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

// Of an accepted state in the potential of this step.
double Equilibrium::elastic_energy_J(const BodyState& from) const {
  if (!step_) return from.elastic_energy_J;
  Points force = Points::Zero(from.u.rows(), 3);
  return body_.energy(from.u) + bed_.add_force(from.u, force);
}

}  // namespace palpate::fem
