#pragma once

#include <optional>
#include <vector>

#include "libfem/contact/contact.hpp"
#include "libfem/solve/elastic_body.hpp"
#include "libfem/solve/schur_factor.hpp"

namespace palpate::fem {

/// How exactly the condensed model is solved.
/// residual: of the contact force on the dense block. limit_change: rounds over the friction limit
/// end when it changes by less. most_iterations, most_rounds: then the answer is taken as it is.
struct ContactModelOptions {
  double residual = 1e-3;
  double limit_change = 0.02;
  int most_iterations = 40;
  int most_rounds = 4;
};

/// The body as the probe feels it: the elastic tangent of some earlier state, condensed to the
/// contact nodes by a SchurFactor. On it contact and friction are solved as they are, with as many
/// iterations as it takes, since one costs a small dense factorization.
class ContactModel {
 public:
  /// All arguments must outlive this.
  ContactModel(const QuadraticMesh& mesh, const ElasticBody& body, Contact& contact,
               SchurFactor& factor);

  /// To be called after each factorization: finds the dense block's nodes.
  void settle();

  /// Puts the stiffness of contact.terms() on the dense block; where that is not positive definite,
  /// without the curvature of the probe, or with springs. False when nothing helps.
  bool use_contact_stiffness(const Points& u, const ProbePose& pose, const ContactHistory& history);

  /// The displacement from u (over the unknowns) to where the model rests: contact and friction by
  /// Newton's method with a line search, in rounds over the friction limit, everything else linear.
  /// elastic_force: dE/du at u, all nodes. stuck: displacement per contact node if the surface went
  /// with the probe, tried as a start; empty to start from u. Leaves the friction limit held.
  /// iterations is increased by those made. Empty when the model has no contact node or breaks down.
  std::optional<Eigen::VectorXd> solve(const Points& u, const Points& elastic_force,
                                       const ProbePose& pose, const ContactHistory& history,
                                       const std::optional<Points>& stuck,
                                       const ContactModelOptions& options, int& iterations);

 private:
  void gather_terms();
  void place(const Points& u, const Eigen::VectorXd& w, Points& out) const;
  Eigen::VectorXd stuck_start(const Points& u, const Points& stuck,
                              const ContactHistory& history) const;

  const QuadraticMesh& mesh_;
  const ElasticBody& body_;
  Contact& contact_;
  SchurFactor& factor_;
  std::vector<std::int32_t> block_of_;  // #N: place in the dense block, -1 elsewhere
  std::vector<std::int32_t> node_of_;   // of each place in the dense block
  Eigen::MatrixXd stiffness_;           // contact.terms() on the dense block, all entries [N/m]
  Eigen::VectorXd force_;               // their force [N]
};

}  // namespace palpate::fem
