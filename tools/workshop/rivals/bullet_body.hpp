#pragma once

#include <memory>

#include "tools/workshop/rivals/coarse_body.hpp"

namespace palpate::tools {

/// How Bullet steps a deformable body.
struct BulletSettings {
  BallContact ball;             ///< no penalty: Bullet's contacts are constraints
  double density_kg_m3 = 3000;  ///< below it, and with more or less damping, steps blow up
  double damping_s = 0.01;      ///< viscosity over modulus
  double step_s = 1e-3;
  int newton = 2;
  double tolerance = 1e-4;  ///< of conjugate gradients, of their right-hand side
};

/// A rigid ball on one of Bullet's deformable bodies (3.24): stable neo-Hookean tets, implicit
/// steps, contacts of nodes and faces with the ball as constraints. Force is what the elements pull
/// the held nodes with: at rest that is the ball's.
class BulletBody {
 public:
  BulletBody(CoarseBody body, const BulletSettings& settings);
  ~BulletBody();

  void start();
  /// Force ON THE BODY [N] of the ball about centre_m, after a step that brings it there.
  Vec3 force(const Vec3& centre_m);
  std::size_t bytes() const;

 private:
  struct World;

  CoarseBody body_;
  BulletSettings settings_;
  std::unique_ptr<World> world_;
};

}  // namespace palpate::tools
