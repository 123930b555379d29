#pragma once

#include <functional>
#include <vector>

#include "libfem/elements/elastic_body.hpp"
#include "libfit/core/geometry.hpp"

namespace palpate::fem {

/// Ten-node tets from straight ones in a parameter domain: corners and edge middles go where
/// `place` puts their parameters. Nothing is held.
QuadraticMesh quadratic(const TetMesh& parameters, const std::function<Vec3(const Vec3&)>& place);

/// Elements, nodes and constraints of a statics problem without contact.
/// prescribed: 3 N displacements [m], NaN where free; load: dead nodal forces [N]. Both are those
/// of the last step and grow in proportion from 0.
struct StaticProblem {
  QuadraticMesh mesh;
  Material material;
  Eigen::VectorXd prescribed;
  Points load;

  StaticProblem(QuadraticMesh mesh_of_body, const Material& of);
  /// Prescribes one component (0-2) of the displacement at nodes where `here` holds at rest.
  void prescribe(const std::function<bool(const Vec3&)>& here, int component, double value_m = 0);
  /// A traction [Pa] per rest area on the boundary faces whose nodes all satisfy `here`.
  void add_traction(const std::function<bool(const Vec3&)>& here, const Vec3& traction_Pa);
  /// A force per rest volume [N/m^3].
  void add_body_force(const std::function<Vec3(const Vec3&)>& force_N_m3);
};

/// u, reaction: N x 3; reaction: gradient of the energy minus load [N]. cpu_s: of the solution.
struct StaticOutcome {
  bool is_solved = false;
  Points u, reaction;
  double min_J = 1;
  int steps = 0, newton = 0;
  double cpu_s = 0;
};

/// Newton's method with a direct solver, in `steps` equal steps that are halved where they fail, to
/// a residual of 1e-10 of the largest nodal force.
StaticOutcome solve(const StaticProblem& problem, int steps);

/// L2 norm over the body of u - exact, by a 14-point rule.
double l2_error(const StaticProblem& problem, const Points& u,
                const std::function<Vec3(const Vec3&)>& exact);

}  // namespace palpate::fem
