#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "libfem/elements/block_matrix.hpp"
#include "libfem/elements/element_kernels.hpp"
#include "libfem/materials/materials.hpp"
#include "libfem/materials/pack_math.hpp"
#include "libfem/mesh/topology.hpp"

namespace palpate::fem {

/// Components of a symmetric tensor at a quadrature point: xx, yy, zz, xy, xz, yz.
inline constexpr int kSymmetric = 6;

/// Internal variables of a relaxing body at a time, batch by batch of ElasticBody, [point][1 +
/// branch] [component] [Pa]: the second Piola-Kirchhoff stress that its shape has in slow motion,
/// then the internal stress of each branch (M14b). Nothing of materials that do not relax. peak:
/// the largest W - U that each point has reached (M54a) [Pa], of materials that soften.
struct MaterialHistory {
  std::vector<PackArray> stress, peak;
};

/// Error of a force by steps in time, relative: what (M14b) leaves of a stress that rises as
/// t^{3/2} where a step is no longer than a sixth of the time since first touch, at the worst ratio
/// of step to branch (tests/libfem/elements).
inline constexpr double kStepError = 0.002;

/// A step of dt_s seconds from a body that remembers `from` (none: at rest) as a potential, batch
/// by batch: (M14a) with stiffening 1 + sum_k g_k z_k and the stress H held meanwhile,
/// [point][component] [Pa]. peak: (M54b), of materials that soften.
struct MaterialStep {
  std::shared_ptr<const MaterialHistory> from;
  double dt_s = 0;
  std::vector<double> stiffening;
  std::vector<PackArray> held, peak;

  double max_stiffening() const;
};

/// A branch over a step of dt = share of its time: e^{-dt/tau} and z = (1 - e^{-dt/tau}) /
/// (dt/tau), which is exact where stress changes evenly over the step (M14b). 0 <= dt_over_time <=
/// inf. Source: Taylor, Pister and Goudreau 1970, doi:10.1002/nme.1620020106.
struct BranchDecay {
  double kept, taken;
};
BranchDecay branch_decay(double dt_over_time);

/// Share a of the law's U(J) that sees the averaged volume change: all but what leaves a
/// small-strain bulk modulus of 5/3 mu at each point, as a material with lambda = mu has, so
/// nothing locks, and what the average cannot see is as stiff as a shear of the same size:
/// a = (lambda - mu) / U''(1), within 0 and 1.
double averaged_share(const Material& material);

/// A quadrature point of an element. shape: N_a. by_xi: dN_a/dxi_j, barycentric coordinates 1 to 3.
/// weight: share of the element's volume in coordinates xi, which is 1/6.
struct ElementPoint {
  Eigen::Vector4d barycentric;
  double weight;
  Eigen::VectorXd shape;
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> by_xi;
};

/// A point of an element at barycentric coordinates.
ElementPoint element_point(const Eigen::Vector4d& barycentric, double weight);

/// The rule of an element: four points, exact to degree 2.
/// Source: Keast 1986 (doi:10.1016/0045-7825(86)90059-9).
std::vector<ElementPoint> element_points();

/// The constant function at points, of norm 1 under the weights [m^3]: [m^-1.5], 0 at points of
/// weight 0.
Eigen::VectorXd unit_constant(const Eigen::VectorXd& weight);

/// Elastic energy of a body of ten-node tetrahedra, and its derivatives.
/// Elements of one material are evaluated eight at a time. The material is looked up at each
/// quadrature point. The volume change is averaged over the points of one material in an element: a
/// border of materials through an element costs neither of them its own volume change.
class ElasticBody {
 public:
  /// The mesh must outlive the body.
  ElasticBody(const QuadraticMesh& mesh, const std::vector<Material>& materials,
              const RegionAt& region_at);

  /// Takes the body to be without stress where its nodes are at the mesh's minus u (#N x 3 [m]),
  /// free of the mesh's own shape, from which displacements count as before.
  void strain_by(Points u);

  /// #N: index among the free nodes, -1 for held ones.
  const std::vector<std::int32_t>& free_index() const { return free_index_; }
  /// Zero matrix over the free nodes with the elements' couplings.
  SymmetricBlockMatrix pattern() const;

  /// Stored energy [J] at displacement u (#N x 3 [m]); +inf where det F <= 0.
  double energy(const Points& u) const;

  /// Energy and, added to force (#N x 3 [N], all nodes), its gradient.
  double add_force(const Points& u, Points& force) const;

  /// Energy, gradient (all nodes) and, added to K (free nodes), the Hessian. geometric_scale: of
  /// the geometric stiffness, see LawRow.
  /// max_pressure: bound, in small-strain shear moduli, on averaged pressures in K. Away from
  /// equilibrium those of nearly incompressible elements are the bulk modulus times what the last
  /// step got wrong; unbounded, they make K indefinite. K is exact where they stay within.
  double add_stiffness(const Points& u, double geometric_scale, Points& force,
                       SymmetricBlockMatrix& K,
                       double max_pressure = std::numeric_limits<double>::infinity()) const;

  /// True if some material has a relaxation.
  bool relaxes() const;
  /// True if some material softens (M54a): steps then start from the largest energies so far.
  bool softens() const;
  /// From here on energy, force and stiffness are those of a step in time; none: of slow motion.
  void set_step(std::shared_ptr<const MaterialStep> step) { step_ = std::move(step); }
  /// The step of dt_s seconds from a body that remembers `from`; none: a body at rest. dt_s:
  /// infinite for slow motion, 0 for a jump (M14b). material_history.cpp
  MaterialStep step_from(std::shared_ptr<const MaterialHistory> from, double dt_s) const;
  /// Steps that a motion between two times since first touch is made in, at least, so that what a
  /// step leaves out stays below kStepError (M14b): a sixth of the later time, unless it is far
  /// shorter or longer than every branch.
  double steps_in_time(double from_s, double to_s) const;
  /// Internal variables at the end of a step that took it to displacement u (M14b).
  MaterialHistory remembered(const Points& u, const MaterialStep& step) const;

  /// Least det F over the quadrature points, of the latest evaluation.
  double min_J() const { return min_J_; }

  /// For tests and measurements: results have the same bits on every instruction set.
  void use(InstructionSet set);

 private:
  struct Batch {
    const LawRow* law;
    double averaged, shear_modulus_Pa;
    std::size_t material;
    CellKernels kernels, kernels_in_step;
    std::int32_t cell[kLanes];         // -1 on idle lanes
    std::vector<std::int32_t> points;  // [node][lane]; one past the nodes on idle lanes
    PackArray gradient, weight, constants, mode;
  };
  void add_batch(const Material& material, std::size_t number,
                 const std::vector<ElementPoint>& points, const std::vector<std::int32_t>& cells,
                 const std::vector<const Material*>& material_at);
  void measure(const std::vector<ElementPoint>& points, Batch& batch) const;
  CellKernels kernels_in_step(const Batch& batch) const;
  const double* displacement_rows(const Points& u) const;
  double integrate(Want want, const Points& u, double geometric_scale, double max_pressure,
                   Points* force, SymmetricBlockMatrix* K) const;

  const QuadraticMesh& mesh_;
  Points strained_by_;  // empty: nothing
  int free_nodes_ = 0;
  std::vector<std::int32_t> free_index_;
  std::vector<Relaxation> relaxations_;  // by material
  std::vector<Softening> softenings_;
  std::vector<Batch> batches_;
  std::shared_ptr<const MaterialStep> step_;
  mutable std::vector<BlockPlace> places_;  // #tets x node pairs, made by pattern()
  // Displacement and force of nodes, two to a Pack: see kPointStride.
  mutable PackArray displacement_rows_, force_rows_;
  mutable double min_J_ = 1;
  InstructionSet set_ = best_instruction_set();
};

}  // namespace palpate::fem
