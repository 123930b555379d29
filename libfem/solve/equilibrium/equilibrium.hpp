#pragma once

#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "libfem/contact/contact.hpp"
#include "libfem/elements/block_matrix.hpp"
#include "libfem/elements/elastic_body.hpp"
#include "libfem/mesh/topology.hpp"
#include "libfem/solve/equilibrium/lumen_pressure.hpp"
#include "libfem/solve/factor/schur_factor.hpp"

namespace palpate::fem {

/// What a place of a body's boundary rests on: force over area and displacement [N/m^3], along the
/// normal and across it.
struct BedStiffness {
  double along_N_m3 = 0, across_N_m3 = 0;
};

/// The bed under a place [m] of the boundary at rest; zeros where there is none. May be empty.
using BedAt = std::function<BedStiffness(const Vec3& rest_position)>;

/// Loads on a body's boundary beside the probe's. In the rest of all else a bed exerts nothing,
/// and stress is in balance with the pressure.
struct BoundaryLoads {
  BedAt bed_at;
  double lumen_pressure_Pa = 0;
};

/// Springs on a body's boundary (Winkler's foundation), linear in the displacement:
/// E = 1/2 int u . k u dA, k = along n n' + across (1 - n n'), n and A of the boundary at rest
/// (M13f). It pulls as it pushes. Integrated with six points a face, so its border may cross one.
class ElasticBed {
 public:
  ElasticBed() = default;
  ElasticBed(const QuadraticMesh& mesh, const BedAt& bed_at);

  bool is_empty() const { return faces_.empty(); }

  /// Energy [J] at displacement u (#N x 3 [m]) and, added to force (#N x 3 [N]), its gradient.
  double add_force(const Points& u, Points& force) const;

  /// Added to K, which couples the nodes of each face; free_index: #N, -1 for held nodes.
  void add_stiffness(const std::vector<std::int32_t>& free_index, SymmetricBlockMatrix& K) const;

 private:
  struct BedFace {
    std::array<std::int32_t, kFaceNodes> node;
    std::array<Mat3, kFaceBlocks> block;  // pairs a >= b
  };
  std::vector<BedFace> faces_;
};

/// Finds the shape without stress that the pressure in its lumens inflates to the mesh's, in which
/// an organ is seen, and strains the body by what is between them (Sellier 2011, An iterative
/// method for the inverse elasto-static problem, J. Fluids Struct. 27). A fixed point with the
/// elastic tangent, without its geometric part, at the first step, under Anderson mixing. Nothing
/// where there is no pressure or no lumen. Throws Error, with `where` a key of the scene, where no
/// such shape is found.
void balance_pressure(const QuadraticMesh& mesh, const BoundaryLoads& loads, ElasticBody& body);

/// Anderson mixing of the fixed-point iteration u <- u + d(u), where K d = b with a symmetric
/// positive definite K that stays the same: the next iterate is the combination of the last ones
/// whose d is smallest in the norm of K. Linear problems then converge as fast as under GMRES.
/// Source: Walker and Ni 2011, doi:10.1137/10078356X.
class AndersonMixing {
 public:
  explicit AndersonMixing(int depth) : depth_(static_cast<std::size_t>(depth)) {}

  /// Forgets all iterates.
  void reset() {
    previous_ = {};
    pairs_.clear();
  }

  /// The step to take in place of d, which is d at first.
  Eigen::VectorXd mix(const Eigen::VectorXd& d, const Eigen::VectorXd& b);

  /// Records the step taken since mix().
  void record(const Eigen::VectorXd& step) { previous_.motion = step; }

 private:
  struct SecantPair {
    Eigen::VectorXd motion, step, load;  // of one iterate, and changes of d and b to the next
  };
  std::size_t depth_;
  SecantPair previous_;
  std::vector<SecantPair> pairs_;
};

/// Newton's matrix of contact on the dense block of a factor, in the unknowns that touch.
/// With the flexibility G of the block, its displacement w and the assumed contact force z, w + G z
/// is constant, and contact requires z = f(w) with the derivative C, which friction makes
/// unsymmetric. Not thread-safe.
class CondensedTangent {
 public:
  /// Changes of w [m] and z [N], over the dense block.
  struct CondensedStep {
    Eigen::VectorXd w, z;
  };

  /// Discards all, for another flexibility.
  void clear() {
    unknowns_.clear();
    stiffness_.resize(0, 0);
  }
  bool is_empty() const { return unknowns_.empty(); }

  /// Makes these unknowns of the block (increasing) its own. Keeps its own where they contain
  /// these and few others.
  void cover(const Eigen::MatrixXf& flexibility, const std::vector<Eigen::Index>& touching);
  const std::vector<Eigen::Index>& unknowns() const { return unknowns_; }

  /// Takes C on unknowns() [N/m] and factors.
  void set_contact(Eigen::MatrixXd C);

  /// Newton's step for the residual z - f(w) of the block [N]: dw solves dw + G C dw = G (z - f),
  /// and dz = C dw - (z - f).
  CondensedStep step(const Eigen::MatrixXf& flexibility, const Eigen::VectorXd& residual) const;

 private:
  std::vector<Eigen::Index> unknowns_;
  Eigen::MatrixXf stiffness_;  // of the body on unknowns(): inverse of their flexibility
  Eigen::MatrixXd C_;
  Eigen::MatrixXf factor_;      // of the sum of both
  std::vector<int> exchanges_;  // of rows, in factor_
};

/// Tolerances of one equilibrium; all relative.
struct EquilibriumOptions {
  double residual = 1e-3;  ///< of the nodal contact forces (2-norm over the unknowns)
  int max_newton = 30;     ///< corrections before a step is given up
  int max_astray = 5;      ///< the same while the residual is above 0.3
  int patience = 8;        ///< corrections after which a factor is made anew
  int stale = 6;    ///< corrections of a solve after which the next begins with a fresh factor
  int mixing = 10;  ///< corrections that Anderson mixing remembers
};

/// Counts of the work that was done; deterministic.
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
  /// A body with a history has that history, the step in whose potential it rests, and the largest
  /// nodal contact force so far (2-norm), the scale of residuals without contact.
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
              const EquilibriumOptions& options = {}, const BoundaryLoads& loads = {});

  /// The body at rest with the probe at `pose`, touching or not.
  BodyState rest(const ProbePose& pose) const;

  /// Moves the probe from an accepted state to `pose`, starting the search at displacement `guess`.
  /// Where that is solved, `to` holds the new state; otherwise its content is the last iterate.
  /// may_shorten: the caller has shorter steps to try, so one that goes astray is given up early.
  bool solve(const BodyState& from, const ProbePose& pose, const Points& guess, BodyState& to,
             bool may_shorten = false);

  /// Later solves are a time step dt_s after `from`, which stays as it is (M14a, M54b). A body is
  /// in slow motion and undamaged until the first of these; one without a history stays so.
  void begin_step(const BodyState& from, double dt_s);
  /// Commits the internal variables at the end of the step to an accepted state, from its own
  /// displacement, or from that after an Uzawa update, which is nearer to a rigid probe's.
  void end_step(BodyState& accepted) const { end_step(accepted.u, accepted); }
  void end_step(const Points& u, BodyState& accepted) const;

  /// The equilibrium at an accepted state's own pose after one augmented-Lagrangian (Uzawa) update
  /// (ContactInterface::updated_multipliers), which is that of a rigid wall but for the second
  /// order. It is not a state to continue from.
  bool uzawa_update(const BodyState& accepted, BodyState& to);

  /// True if an accepted state is stable with the probe held where it is: its tangent, contact and
  /// sticking friction included, is positive definite. Costs a factorization.
  bool is_stable(const BodyState& accepted);

  /// Multiplies the contact penalty from here on; accepted states stay valid.
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
  std::int32_t contact_place(int face, int node) const;
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
  LumenPressure lumen_;
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
