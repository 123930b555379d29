#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <vector>

#include "tools/workshop/rivals/coarse_body.hpp"

namespace palpate::tools {

/// How a ball is solved for on a corotational body.
struct CorotationalSettings {
  BallContact ball;
  int newton = 2, solver = 100;  ///< steps of a tick, iterations of each at most
  double tolerance = 1e-3;       ///< residual of an iteration, of its right-hand side
};

/// A corotational body (Mueller and Gross 2004, doi:10.5555/1006058.1006087) at rest under a rigid
/// ball at every tick: linear elements turned with their rotation (Mueller et al. 2016,
/// doi:10.1145/2994258.2994269), a penalty on the points that it carries, Coulomb friction by a
/// tangential spring on each that slips at the limit. A tick is some Newton steps from the last
/// state, each by conjugate gradients with the diagonal blocks. There is no inertia, which would
/// add to the force of a slow tool.
class CorotationalBody {
 public:
  CorotationalBody(CoarseBody body, const CorotationalSettings& settings);
  CorotationalBody(const CorotationalBody&) = delete;

  void start();
  /// Force ON THE BODY [N] of the ball about centre_m.
  Vec3 force(const Vec3& centre_m);
  std::size_t bytes() const;
  const Points& displacement() const { return u_; }

 private:
  using Block = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  using Stiffness = Eigen::Matrix<double, 12, 12>;
  void make_pattern();
  void add_elements(Points& force, bool with_stiffness);
  bool add_contact(Points& force);
  void solve(const Points& residual, Points& step) const;
  void multiply(const Points& x, Points& y) const;
  Block& block(int row, int column);

  CoarseBody body_;
  CorotationalSettings settings_;
  std::vector<Stiffness> stiffness_;  // of each tet at rest
  std::vector<Mat3> inverse_;         // of its edges
  std::vector<Eigen::Quaterniond> turn_;
  std::vector<int> row_start_, column_;
  std::vector<Block> blocks_;
  CarriedContact contact_;
  Points u_;
};

}  // namespace palpate::tools
