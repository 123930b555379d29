#pragma once

#include <vector>

#include "libfit/validation/replay.hpp"
#include "libfit/validation/statement.hpp"

namespace palpate::validation {

/// A row's torque on the body, of the reference and of the engine [N m], about the same point.
struct ComparedTorque {
  Vec3 reference_Nm = Vec3::Zero();
  Vec3 engine_Nm = Vec3::Zero();
};

/// Good reference rows of the paths that `counts` names, with what was answered. About the centre
/// of a ball of radius_m, where only friction turns it; 0: about the tip (M58a).
std::vector<ComparedTorque> compared_torques(const Reference& reference, const Replayed& engine,
                                             double radius_m,
                                             const std::function<bool(std::size_t path)>& counts);

/// Floor of the relative errors of a body's torques, all of which are given [N m] (M58a).
double torque_floor_Nm(const std::vector<ComparedTorque>& rows);

/// Figures of some rows of a body with this floor (M58a); nearest-rank. No relative ones where
/// nothing turned the tool at all.
NamedTorque named_torque(std::string name, const std::vector<ComparedTorque>& rows,
                         double floor_Nm);

/// Of all rows, then by kind of path in the order of kPathKindNames. Nothing where no row is good.
std::vector<NamedTorque> torque_errors(const Reference& reference, const Replayed& engine,
                                       double radius_m);

}  // namespace palpate::validation
