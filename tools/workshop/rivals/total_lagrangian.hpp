#pragma once

#include <vector>

#include "tools/workshop/rivals/coarse_body.hpp"

namespace palpate::tools {

/// How a body moves between ticks.
struct ExplicitSettings {
  BallContact ball;
  double density_kg_m3 = 1000;
  double damping_Hz = 300;      ///< force of the damping on a node, of its momentum
  double tick_s = 1e-3;         ///< of real time
  double step_of_stable = 0.6;  ///< of the longest stable step at rest: elements shorten
};

/// A total-Lagrangian explicit body under a rigid ball (Miller et al. 2007,
/// doi:10.1002/cnm.887): linear tets of a nearly incompressible neo-Hookean material with gradients
/// stored at rest, lumped masses, central differences with damping by mass. A tick is as many
/// stable steps as fit into a millisecond; the longest is that of the highest frequency at rest,
/// with every carried point pressed.
class ExplicitBody {
 public:
  ExplicitBody(CoarseBody body, const ExplicitSettings& settings);
  ExplicitBody(const ExplicitBody&) = delete;

  void start();
  /// Force ON THE BODY [N] of the ball about centre_m, at the end of the tick.
  Vec3 force(const Vec3& centre_m);
  std::size_t bytes() const;
  int steps() const { return steps_; }
  const Points& displacement() const { return u_; }

 private:
  struct ExplicitElement {
    Eigen::Matrix<double, 4, 3> gradient;
    double volume_m3, shear_Pa, bulk_Pa;
  };

  void add_elements(const Points& u, Points& force) const;
  double highest_squared_Hz();

  CoarseBody body_;
  ExplicitSettings settings_;
  std::vector<ExplicitElement> element_;
  Eigen::VectorXd mass_kg_;
  CarriedContact contact_;
  Points u_, before_;
  int steps_ = 1;
};

}  // namespace palpate::tools
