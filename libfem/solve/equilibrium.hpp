#pragma once

#include <vector>

#include "libfem/contact/contact.hpp"
#include "libfem/solve/cholesky.hpp"
#include "libfem/solve/elastic_body.hpp"

namespace palpate::fem {

/// Tolerances of one equilibrium; all relative.
struct EquilibriumOptions {
  double residual = 1e-3;   ///< of the nodal contact forces (2-norm over the unknowns)
  double linear = 0.05;     ///< of the residual, per linear solve
  int most_newton = 30;     ///< iterations before a step is given up
  int most_pcg = 12;        ///< iterations that are worth a fresh factor
};

/// What was spent; deterministic.
struct SolverCounts {
  int newton = 0, pcg = 0, factorizations = 0, failed_factorizations = 0, line_searches = 0;
};

enum class SolveStatus { solved, not_converged, inverted };

/// A body in equilibrium with the probe. u: #N x 3 [m].
struct BodyState {
  Points u;
  ProbePose pose;
  ContactHistory history;
  ContactTotals contact;
  double relative_residual = 0;
  double least_J = 1;
};

/// Equilibrium of one body under one probe: Newton's method with conjugate gradients on the current
/// tangent, preconditioned by the factor of an earlier one, and a line search on the incremental
/// energy. Not thread-safe: owns matrices, factor and contact scratch.
class Equilibrium {
 public:
  /// mesh must outlive this. young_Pa of faces follows region_at at their centres.
  Equilibrium(const QuadraticMesh& mesh, const std::vector<Material>& materials,
              const RegionAt& region_at, const Probe& probe,
              const ContactSettings& contact = {}, const EquilibriumOptions& options = {});

  /// The body at rest with the probe at `pose`, touching or not.
  BodyState rest(const ProbePose& pose) const;

  /// Moves the probe from an accepted state to `pose`, starting the search at displacement `guess`.
  /// On `solved`, `to` holds the new state; otherwise its content is the last iterate.
  SolveStatus solve(const BodyState& from, const ProbePose& pose, const Points& guess,
                    BodyState& to);

  /// Sum of the forces of the ground on the body at held nodes [N]; minus the contact force in
  /// equilibrium.
  Vec3 reaction_N(const Points& u) const;

  const EquilibriumOptions& options() const { return options_; }
  const SolverCounts& counts() const { return counts_; }
  const ElasticBody& body() const { return body_; }
  const Cholesky& factor() const { return factor_; }
  Contact& contact() { return contact_; }
  int unknowns() const { return K_.size(); }

 private:
  double assemble(const Points& u, const ProbePose& pose, const ContactHistory& history,
                  double bend, BodyState& to);
  void refresh_factor(const Points& u, const ProbePose& pose, const BodyState& from, BodyState& to);
  Eigen::VectorXd newton_direction(const Points& u, const ProbePose& pose, const BodyState& from,
                                   BodyState& to);
  double energy(const Points& u, const ProbePose& pose, const ContactHistory& history) const;
  bool search_line(const Eigen::VectorXd& direction, const ProbePose& pose,
                   const ContactHistory& history, Points& u);
  Points moved(const Points& u, const Eigen::VectorXd& direction, double length) const;

  const QuadraticMesh& mesh_;
  EquilibriumOptions options_;
  ElasticBody body_;
  Contact contact_;
  SymmetricBlockMatrix K_;
  std::vector<BlockPlace> face_places_;  // #F x kFaceBlocks
  Cholesky factor_;
  double bend_ = 1;          // ladder level of the factor: 1, 0.5, 0
  Eigen::VectorXd residual_;  // over the unknowns [N]
  double contact_scale_N_ = 0;
  SolverCounts counts_;
};

}  // namespace palpate::fem
