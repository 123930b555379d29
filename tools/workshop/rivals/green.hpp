#pragma once

#include <memory>
#include <vector>

#include "libfem/solve/experiments/simulator.hpp"
#include "tools/workshop/rivals/rival.hpp"

namespace palpate::tools {

/// Green's functions of a body's surface (Cotin, Delingette and Ayache 1999,
/// doi:10.1109/2945.764872; James and Pai 1999, doi:10.1145/311535.311542): displacement of each
/// node of a window under a unit force on each, by the linear stiffness of the body at rest.
struct GreenSurface {
  Points node;                 ///< n x 3, at rest [m]
  Eigen::MatrixXf compliance;  ///< 3n x 3n [m/N]
  int mesh_nodes = 0;
};

/// Places that cover the window of a body: no place of it is farther than `within_m` from all.
Points window_cover(const Body& body, double within_m);

/// A mesh of a setup's body, of size_m within reach_m of each place of `window`, coarser beyond.
fem::QuadraticMesh window_mesh(const fem::SimulationSetup& setup, const Points& window,
                               double size_m, double reach_m);

/// The body of a setup, its mesh of size_m around `window` (reach_m about each place); nodes of the
/// surface within reach_m of a place are kept. Throws Error where the stiffness has no factor.
GreenSurface make_green_surface(const fem::SimulationSetup& setup, const Points& window,
                                double size_m, double reach_m);

/// How a ball is solved for on Green's functions.
struct GreenSettings {
  double radius_m = 0, friction = 0;
  int max_sweeps = 100;
  double tolerance = 2e-4;  ///< change of force of a sweep, of the force of all nodes
};

/// A rigid ball on Green's functions. At each tick the nodes about the ball do not overlap it, are
/// not pulled, and stick or slip by Coulomb's law against where they were at the last tick:
/// projected Gauss-Seidel from the last tick's forces (Duriez et al. 2006,
/// doi:10.1109/TVCG.2006.13).
class GreenContact {
 public:
  GreenContact(std::shared_ptr<const GreenSurface> surface, const GreenSettings& settings);

  /// The ball is free again.
  void start();
  /// Force ON THE BODY [N] of the ball about centre_m.
  Vec3 force(const Vec3& centre_m);
  std::size_t bytes() const;

 private:
  bool gather(const Vec3& centre_m);
  double sweep(const Vec3& centre_m, const Vec3& moved_m);

  std::shared_ptr<const GreenSurface> held_;
  const GreenSurface& surface_;
  GreenSettings settings_;
  bool has_centre_ = false;
  Vec3 centre_m_ = Vec3::Zero();
  std::vector<int> active_;         // nodes about the ball
  Eigen::MatrixXf compliance_;      // of these
  Eigen::VectorXf force_, all_;     // on these [N]; on all nodes
  Eigen::VectorXf moved_, before_;  // of these [m]; at the last tick
};

}  // namespace palpate::tools
