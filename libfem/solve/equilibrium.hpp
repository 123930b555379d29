#pragma once

#include <optional>
#include <vector>

#include "libfem/contact/contact.hpp"
#include "libfem/solve/contact_model.hpp"
#include "libfem/solve/elastic_body.hpp"
#include "libfem/solve/schur_factor.hpp"

namespace palpate::fem {

/// Tolerances and limits of one equilibrium; all relative, all found by measurement.
struct EquilibriumOptions {
  double residual = 3e-3;    ///< out-of-balance force over nodal contact force, 2-norms
  double linear = 0.05;      ///< of the residual, per linear solve
  int most_newton = 12;      ///< iterations before a step is given up
  int most_pcg = 12;         ///< applications of the factor that are worth a fresh one
  int stale_pcg = 10;        ///< applications in a solve after which the next starts afresh
  double trusted = 0.05;     ///< residual over contact force that the condensed model may leave
  double contraction = 0.5;  ///< of the residual, without which the factor is refreshed
  double hopeless = 0.3;     ///< residual over contact force at which a step is cut instead
  double hopeless_at_first = 0.8;  ///< the same after the first iteration
  double contact_margin = 0.7;  ///< gap, in steps of the probe, up to which nodes are contact nodes
  ContactModelOptions model;
};

/// What was spent; deterministic.
struct SolverCounts {
  int newton = 0;          ///< linearisations followed by a step
  int pcg = 0;             ///< applications of the factor in conjugate gradients
  int model = 0;           ///< iterations of the condensed model
  int factorizations = 0;
  int failed_factorizations = 0;
  int backtracks = 0;
};

enum class SolveStatus { solved, not_converged, inverted };

/// A body in equilibrium with the probe. u: #N x 3 [m].
struct BodyState {
  Points u;
  ProbePose pose;
  ContactHistory history;
  ContactTotals contact;
  double contact_scale_N = 0;    ///< 2-norm of the nodal contact forces
  double relative_residual = 0;  ///< of it
  double least_J = 1;
};

/// Equilibrium of one body under one probe.
///
/// A step starts on the condensed ContactModel, which finds contact and friction on an earlier
/// elastic tangent. Where that leaves little out of balance, Newton's method follows: conjugate
/// gradients on the current tangent, preconditioned by the earlier one plus the current contact
/// stiffness, and a line search on the incremental energy with the friction limit held. Where it
/// leaves much, the tangent is factored anew. Decisions follow counts and residuals, never clocks.
/// Not thread-safe: owns matrices, factor and contact scratch.
class Equilibrium {
 public:
  /// mesh must outlive this. The contact stiffness of a face follows the material at its centre.
  Equilibrium(const QuadraticMesh& mesh, const std::vector<Material>& materials,
              const RegionAt& region_at, const Probe& probe,
              const ContactSettings& contact = {}, const EquilibriumOptions& options = {});
  Equilibrium(const Equilibrium&) = delete;
  Equilibrium& operator=(const Equilibrium&) = delete;

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
  const SchurFactor& factor() const { return factor_; }
  int unknowns() const { return K_.size(); }

 private:
  /// The equations at one displacement.
  struct Local {
    Points u;
    Points elastic_force;      // dE/du of all nodes [N]
    Eigen::VectorXd residual;  // out-of-balance force over the unknowns [N]
  };

  Points start_of_search(const BodyState& from, const ProbePose& pose, const Points& guess) const;
  void assemble_elastic(double bend, Local& at);
  void add_contact(const BodyState& from, Local& at, BodyState& to);
  void linearise(const BodyState& from, Local& at, BodyState& to);
  void refresh_factor(const BodyState& from, Local& at, BodyState& to);
  std::vector<std::int32_t> nodes_near_probe(const Points& u, const ProbePose& pose,
                                             double within_m) const;
  bool step_by_model(const BodyState& from, const ProbePose& pose, bool is_first, Local& at);
  bool step_by_newton(const BodyState& from, Local& at, BodyState& to);
  double energy(const Points& u, const ProbePose& pose, const ContactHistory& history) const;
  bool search_line(const Eigen::VectorXd& direction, double slope, const ProbePose& pose,
                   const ContactHistory& history, Points& u);
  Points moved(const Points& u, const Eigen::VectorXd& direction, double length) const;

  const QuadraticMesh& mesh_;
  EquilibriumOptions options_;
  ElasticBody body_;
  Contact contact_;
  SymmetricBlockMatrix K_;
  std::vector<BlockPlace> face_places_;  // #F x kFaceBlocks
  SchurFactor factor_;
  ContactModel model_;
  double bend_ = 1;        // ladder level of the factor: 1, 0.5, 0
  bool is_stale_ = true;   // the factor, at the next solve
  double step_m_ = 0;      // of the probe, in this solve
  SolverCounts counts_;
};

}  // namespace palpate::fem
