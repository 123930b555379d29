#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <vector>

#include "libfit/core/geometry.hpp"
#include "tools/bench/rivals/rival.hpp"

namespace palpate::tools {

/// A point of the fine surface that moves with a tet, by barycentric weights that may be below 0.
struct CarriedPoint {
  int tet = 0;
  Eigen::Vector4d weight = Eigen::Vector4d::Zero();
  double area_m2 = 0;
};

/// A coarse body of linear tetrahedra that carries points of a fine surface, which touch.
struct CoarseBody {
  Points nodes;
  Tets tets;
  std::vector<char> is_held;
  Eigen::VectorXd young_Pa, poisson;  ///< of each tet
  std::vector<CarriedPoint> carried;
};

/// Three points on each triangle of a surface of which a corner is near a place (within_m).
std::vector<CarriedPoint> carried_points(const Points& nodes, const Tets& tets,
                                         const Surface& surface, const Points& places,
                                         double within_m);

/// How a ball is solved for on a corotational body.
struct CorotationalSettings {
  double radius_m = 0, friction = 0;
  double penalty_Pa_m = 0;       ///< pressure over depth of overlap
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

  void start();
  /// Force ON THE BODY [N] of the ball about centre_m.
  Vec3 force(const Vec3& centre_m);
  std::size_t bytes() const;
  const Points& displacement() const { return u_; }

 private:
  using Block = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  using Stiffness = Eigen::Matrix<double, 12, 12>;
  // What a carried point did: its side force, and where it was at the last tick.
  struct CarriedTouch {
    Vec3 side_N = Vec3::Zero(), side_before_N = Vec3::Zero(), place_before_m = Vec3::Zero();
    bool is_pressed = false;
  };

  void make_pattern();
  void add_elements(Points& force, bool with_stiffness);
  Vec3 place_of(std::size_t point) const;
  bool add_touch(std::size_t point, const Vec3& centre_m, const Vec3& moved_m, Points& force);
  bool add_contact(const Vec3& centre_m, const Vec3& moved_m, Points& force);
  void remember_touches(const Vec3& centre_m);
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
  std::vector<CarriedTouch> touch_;  // of each carried point
  std::vector<std::size_t> near_;    // of them, about the ball
  Points u_;
  bool has_centre_ = false;
  Vec3 centre_m_ = Vec3::Zero();
};

std::vector<Rival> prepare_corotational(const RivalBody& body);

}  // namespace palpate::tools
