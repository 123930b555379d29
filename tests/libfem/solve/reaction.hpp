#pragma once

#include <Eigen/Geometry>

#include "libfem/solve/equilibrium/equilibrium.hpp"

namespace palpate::fem {

/// Sum of the forces of the ground on the body at held nodes [N], and of their moments about a
/// point [N m].
struct Reaction {
  Vec3 force_N = Vec3::Zero(), moment_Nm = Vec3::Zero();
};

inline Reaction reaction(const Equilibrium& equilibrium, const QuadraticMesh& mesh, const Points& u,
                         const Vec3& about = Vec3::Zero()) {
  Points gradient = Points::Zero(u.rows(), 3);
  equilibrium.body().add_force(u, gradient);
  Reaction sum;
  for (Eigen::Index n = 0; n < u.rows(); ++n) {
    if (!mesh.is_held[n]) continue;
    const Vec3 at = (mesh.nodes.row(n) + u.row(n)).transpose() - about;
    const Vec3 force = gradient.row(n);
    sum.force_N += force;
    sum.moment_Nm += at.cross(force);
  }
  return sum;
}

}  // namespace palpate::fem
