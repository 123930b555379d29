#pragma once

#include <memory>
#include <vector>

#include "libfem/contact/contact.hpp"
#include "libfem/elements/elastic_body.hpp"
#include "libfem/solve/equilibrium/anderson.hpp"
#include "libfem/solve/equilibrium/condensed_tangent.hpp"
#include "libfem/solve/equilibrium/elastic_bed.hpp"
#include "libfem/solve/factor/schur_factor.hpp"

namespace palpate::fem {

/// Tolerances of one equilibrium; all relative.
struct EquilibriumOptions {
  double residual = 1e-3;  ///< of the nodal contact forces (2-norm over the unknowns)
  int max_newton = 30;     ///< corrections before a step is given up
  int max_astray = 5;      ///< the same while the residual is above 0.3
  int patience = 8;        ///< corrections after which a factor is made anew
  int stale = 6;       ///< corrections of a solve after which the next begins with a fresh factor
  int mixing = 10;     ///< corrections that Anderson mixing remembers
  double model = 0.1;  ///< residual of the condensed model, of that of the body or its goal
  double model_lagged = 0.1;  ///< the same at which friction is coupled
  int max_model = 20;         ///< iterations of the condensed model
  double max_pressure = 2;    ///< in the tangent, in shear moduli: see ElasticBody::add_stiffness
  double contact_margin = 1;  ///< faces this close become contact nodes, in steps of the probe
};

/// What was spent; deterministic.
struct SolverCounts {
  int newton = 0;  ///< corrections: a residual and a solve with the factor each
  int model = 0;   ///< iterations of the condensed contact model
  int factorizations = 0;
};

/// A body in equilibrium with the probe. u: #N x 3 [m].
struct BodyState {
  Points u;
  ProbePose pose;
  ContactHistory history;
  ContactTotals contact;
  double relative_residual = 0;
  double min_J = 1;
  double elastic_energy_J = 0;
  /// Of a relaxing body in time: what it remembers, the step whose potential it rests in, and the
  /// largest nodal contact force on the way (2-norm), which residuals without contact are held
  /// against.
  std::shared_ptr<const MaterialHistory> memory;
  std::shared_ptr<const MaterialStep> step;
  double largest_contact_N = 0;
};

/// Equilibrium of one body under one probe (M13).
/// A correction takes the elastic forces as they are and the elastic tangent of an earlier state,
/// condensed to the contact nodes, on which contact and friction are solved exactly. Corrections
/// follow each other, combined by Anderson mixing, with a line search on the incremental energy
/// for the friction limit that the correction found. Not thread-safe: owns matrices, factor and
/// contact scratch.
class Equilibrium {
 public:
  /// mesh must outlive this. young_Pa of faces follows region_at at their centres.
  Equilibrium(const QuadraticMesh& mesh, const std::vector<Material>& materials,
              const RegionAt& region_at, const Probe& probe, const ContactSettings& contact = {},
              const EquilibriumOptions& options = {}, const BedAt& bed_at = {});

  /// The body at rest with the probe at `pose`, touching or not.
  BodyState rest(const ProbePose& pose) const;

  /// Moves the probe from an accepted state to `pose`, starting the search at displacement `guess`.
  /// Where that is solved, `to` holds the new state; otherwise its content is the last iterate.
  /// may_shorten: the caller has shorter steps to try, so one that goes astray is given up early.
  bool solve(const BodyState& from, const ProbePose& pose, const Points& guess, BodyState& to,
             bool may_shorten = false);

  /// Solves from here on are those dt_s after `from`, which stays as it is (M14a, M54b). A body is
  /// in slow motion and undamaged until the first of these; one that does not remember stays so.
  /// equilibrium_in_time.cpp
  void begin_step(const BodyState& from, double dt_s);
  /// Takes what the body remembers at the end of the step into an accepted state, from its own
  /// displacement, or from that after an Uzawa update, which is nearer to a rigid probe's.
  void end_step(BodyState& accepted) const { end_step(accepted.u, accepted); }
  void end_step(const Points& u, BodyState& accepted) const;

  /// The equilibrium at an accepted state's own pose after one augmented-Lagrangian (Uzawa) update
  /// (Contact::updated_multipliers): what a rigid wall would do, but for the second order. Not a
  /// state to go on from.
  bool uzawa_update(const BodyState& accepted, BodyState& to);

  /// Whether an accepted state is stable with the probe held where it is: its tangent, contact and
  /// sticking friction included, is positive definite. Costs a factorization.
  bool is_stable(const BodyState& accepted);

  /// Multiplies the contact penalty from here on; accepted states can be gone on from.
  void stiffen_contact(double factor) { contact_.stiffen(factor); }

  const EquilibriumOptions& options() const { return options_; }
  const SolverCounts& counts() const { return counts_; }
  const ElasticBody& body() const { return body_; }

 private:
  /// The equations at one displacement.
  struct Local {
    Points u;
    Points elastic_force;      // dE/du of all nodes [N]
    Eigen::VectorXd residual;  // out-of-balance force over the unknowns [N]
    double contact_scale_N = 0;
    double elastic_energy_J = 0;
    double energy_J = 0;  // with the probe, for the lagged friction limit
  };

  /// A step being solved: from an accepted state to the probe at `pose`, now at `at`; `to` takes
  /// what is found.
  struct Step {
    const BodyState& from;
    const ProbePose& pose;
    BodyState& to;
    Local at = {};

    ContactTrial trial() const { return {at.u, pose, from.history}; }
  };

  /// K displacement = load, over the unknowns, with the factor's K.
  struct Correction {
    Eigen::VectorXd displacement, load;
  };

  class CondensedContact;

  void assemble_elastic(double geometric_scale, double max_pressure, Local& at);
  void evaluate(Step& step);
  void add_contact(Step& step);
  void start(Step& step, const Points& guess);
  void refresh_factor(Step& step);
  void index_contact_nodes();
  std::vector<std::int32_t> nodes_near_probe(const Points& u, const ProbePose& pose,
                                             double within_m) const;
  Eigen::MatrixXd condensed_stiffness(const std::vector<Eigen::Index>& unknowns) const;
  Correction correction(const Step& now);
  bool take(const Correction& correction, AndersonMixing& mixing, Step& step);
  bool touches_elsewhere() const;
  double elastic_energy_J(const BodyState& from) const;
  void resume(std::shared_ptr<const MaterialStep> step);
  double search_line(const Eigen::VectorXd& direction, int tries, Step& step);
  Points moved(const Points& u, const Eigen::VectorXd& direction, double length) const;

  const QuadraticMesh& mesh_;
  EquilibriumOptions options_;
  ElasticBody body_;
  ElasticBed bed_;
  ContactInterface contact_;
  SymmetricBlockMatrix K_;  // elastic; contact is added where it is used
  SchurFactor factor_;
  CondensedTangent tangent_;
  std::vector<std::int32_t> contact_index_;  // #N: place in the factor's dense block, -1 elsewhere
  double geometric_scale_ = 1;               // of the factor: 1, 0.5, 0
  double step_m_ = 0;                        // of the probe, in this solve
  bool is_stale_ = false;
  std::shared_ptr<const MaterialStep> step_;
  double factored_stiffening_ = 1;
  SolverCounts counts_;
};

}  // namespace palpate::fem
