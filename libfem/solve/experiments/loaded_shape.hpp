#pragma once

#include "libfem/mesh/closest_tet.hpp"
#include "libfem/solve/experiments/simulator.hpp"

namespace palpate::fem {

/// How the base mesh of a body is bent by its weight.
class LoadedShape {
 public:
  /// loaded: base mesh under its weight; sag: #nodes x 3 [m], what the weight has moved them by.
  LoadedShape(TetMesh loaded, Points sag);

  /// What a place of the bent body [m] has been moved by, linear in each tet.
  Vec3 sag_at(const Vec3& place) const;
  /// The same for each node of a mesh that the base was graded into, with its origin at `origin`.
  Points sag_of(const QuadraticMesh& mesh, const Vec3& origin) const;

  const Points& sag() const { return sag_; }
  /// Largest |sag| of a node [m].
  double largest_m() const { return sag_.rowwise().norm().maxCoeff(); }

  double residual_m = 0;         ///< of the search, largest distance from the shape that was given
  Eigen::VectorXf surface = {};  ///< 3V [m]: what the vertices of the fine surface have moved by

 private:
  TetMesh loaded_;
  Points sag_;
  BoxTree boxes_;
};

/// The shape at rest of a body that is given under its weight, in coordinates about `origin`.
/// Throws Error where none is found, and says at what share of the weight.
LoadedShape unbend_base(const SimulationSetup& setup, const Vec3& origin = Vec3::Zero());

/// The shape under its weight of a body that is given at rest. Throws Error likewise.
LoadedShape bend_base(const SimulationSetup& setup);

}  // namespace palpate::fem
